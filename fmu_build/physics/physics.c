/* Physical effects that a twin may lack, added at its ports: every effect is off at size zero.
 *
 * An effect is one function in one of the headers, its parameters in model.toml, and one line in
 * `torque_effects`, `command_effects` or `sensor_effects`. It sees the twin's outputs at the start
 * of a step, and what it returns is held over the step; memory is a plain struct in Model. */
#include "backlash.h"
#include "forces.h"
#include "friction.h"
#include "harmonics.h"
#include "hysteresis.h"
#include "limits.h"
#include "load.h"
#include "sensor.h"
#include "thermal.h"
#include "timing.h"
#include "tracking.h"

struct Model {
    double v[N_VARIABLES];
    LastStep last;
    Bristle coulomb, stribeck, presliding, asymmetric, load_dependent, position_dependent;
    Gap gap;
    Spring spring;
    Hysteresis hysteresis;
    Inertia inertia;
    Warming motor;
    Follower rate_limit, lag;
    DelayLine delay;
    double last_added; /* to the command */
    SensorLag sensor_lag;
    Homing homing;
    Tracking tracking;
};
const size_t model_bytes = sizeof(struct Model);

static double torque_effects(Model *m, const Signals *s) {
    const double *v = m->v;
    double torque = 0.0;
    torque += coulomb_friction(&m->coulomb, v, s);
    torque += stribeck_friction(&m->stribeck, v, s);
    torque += presliding_friction(&m->presliding, v, s);
    torque += asymmetric_friction(&m->asymmetric, v, s);
    torque += load_dependent_friction(&m->load_dependent, v, s);
    torque += position_dependent_friction(&m->position_dependent, v, s);
    torque += viscous_friction(v, s);
    torque += quadratic_drag(v, s);
    torque += backlash(&m->gap, v, s);
    torque += torsional_compliance(&m->spring, v, s);
    torque += load_inertia(&m->inertia, v, s);
    torque += hysteresis(&m->hysteresis, v, s);
    torque += cogging_torque(v, s);
    torque += torque_ripple(v, s);
    torque += gravity_torque(v, s);
    torque += elastic_return(v, s);
    torque += constant_torque_offset(v);
    torque += periodic_disturbance(v, s);
    torque += pulse_disturbance(v, s);
    return torque;
}

/* The chain that the command runs through, less the command itself. */
static double command_effects(Model *m, const Signals *s) {
    const double *v = m->v;
    double u = s->command;
    u = actuator_gain_loss(v, u);
    u = magnetic_saturation(v, u);
    u = thermal_derating(&m->motor, v, s, u);
    u = actuator_dead_zone(v, u);
    u = actuator_saturation(v, u);
    u = supply_voltage_limit(v, s, u);
    u = actuator_rate_limit(&m->rate_limit, v, s, u);
    u = actuator_lag(&m->lag, v, s, u);
    u = transport_delay(&m->delay, v, s, u);
    return u - s->command;
}

/* The controller inside a twin shows its command a step late, where the step holds it already. What
 * is added goes on for that time along its last change: the impulse of a changing command is then
 * right. A mass under sampled control at ten steps a sample came out 30 to 500 times closer to
 * the effect at its true place, whatever the effect; more dead time in the effect itself came out
 * farther from it. */
static double command_made_up(Model *m, const Signals *s) {
    double added = command_effects(m, s);
    double rate = rate_of_change(added, m->last_added, m->last.step);
    m->last_added = added;
    return added + rate * m->v[V_settings_command_lateness];
}

static double sensor_effects(Model *m, const Signals *s) {
    const double *v = m->v;
    if (chosen(v[V_tracking_sensor])) return tracking_reading(v, s);
    double reading = 0.0;
    reading += sensor_offset(v);
    reading += sensor_scale(v, s);
    reading += sensor_eccentricity(&m->homing, v, s);
    reading += sensor_lag(&m->sensor_lag, v, s, m->last.step);
    return reading;
}

/* Nothing added leaves every bit, the sign of a zero too. */
static double joined(double passed, double added) { return added == 0.0 ? passed : passed + added; }

const char *model_initialise(Model *m, const char *resources) {
    (void)resources;
    m->v[V_torque] = m->v[V_port_torque];
    m->v[V_command] = m->v[V_port_command];
    m->v[V_sensor] = m->v[V_port_sensor];
    return NULL;
}

const char *model_step(Model *m, double t, double h) {
    double *v = m->v;
    if (v[V_transport_delay_delay] > DELAY_REACH * h)
        return "transport_delay.delay is longer than 2046 steps: shorten it or take longer steps";
    Signals s = signals_now(v, &m->last, t, h);
    v[V_tracking_effort] = tracking_effort(&m->tracking, v, &s, m->last.step);
    v[V_torque] = joined(v[V_port_torque], torque_effects(m, &s) + v[V_tracking_effort]);
    v[V_command] = joined(v[V_port_command], command_made_up(m, &s));
    v[V_sensor] = joined(v[V_port_sensor], sensor_effects(m, &s));
    m->last = last_step(&s);
    return isfinite(v[V_torque]) && isfinite(v[V_command]) && isfinite(v[V_sensor])
               ? NULL
               : "an effect has diverged: its size, or the state of the twin, is too large";
}

const char *model_parameter_changed(Model *m, int index) {
    (void)m, (void)index; /* read again in every step */
    return NULL;
}
