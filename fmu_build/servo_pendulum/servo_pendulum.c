/* Hobby servo that swings a pendulum (the rig of Duclusaud et al. 2025): a proportional law in the
 * firmware sets the duty of a PWM; behind it a motor with back-EMF, no inductance, an armature and
 * a point mass. All of it is told at the output shaft. */
#include <math.h>

#include "model.h"
#include "sampling.h"

#define GRAVITY 9.80665 /* [m/s2] standard */

struct Model {
    double v[N_VARIABLES];
    Sampler sampler;
    double position; /* [rad] */
    double velocity; /* [rad/s] */
};
const size_t model_bytes = sizeof(struct Model);

static int bridge_is_closed(const Model *m) { return m->v[V_enabled] > 0.5; }

static double inertia(const double *v) {
    return v[V_motor_armature] + v[V_load_mass] * v[V_load_length] * v[V_load_length];
}

static double gravity_torque(const double *v, double position) {
    return v[V_load_mass] * GRAVITY * v[V_load_length] * sin(position + v[V_load_tilt]);
}

/* kt (V - kt w) / R; an open bridge carries no current. */
static double motor_torque(const Model *m, double velocity) {
    const double *v = m->v;
    if (!bridge_is_closed(m)) return 0.0;
    double voltage = v[V_voltage] + v[V_port_command] - v[V_motor_torque_constant] * velocity;
    return v[V_motor_torque_constant] * voltage / v[V_motor_resistance];
}

static double acceleration(const Model *m, double position, double velocity) {
    const double *v = m->v;
    double torque = motor_torque(m, velocity) + v[V_port_torque] - gravity_torque(v, position);
    return (torque - v[V_viscous] * velocity) / inertia(v);
}

static void refresh_outputs(Model *m) {
    double *v = m->v;
    v[V_position] = m->position + v[V_port_sensor];
    v[V_true_position] = m->position;
    v[V_velocity] = m->velocity;
    v[V_motor_torque] = motor_torque(m, m->velocity);
    v[V_gravity_torque] = gravity_torque(v, m->position);
    v[V_load_torque] = 0.5 * (v[V_motor_torque] + v[V_gravity_torque]);
}

/* duty_k = sat(kp c (goal_k - reading_k)); the command port acts behind it. */
static void control(Model *m) {
    double *v = m->v, limit = v[V_servo_duty_limit];
    double error = v[V_reference] - (m->position + v[V_port_sensor]);
    double duty = v[V_servo_kp] * v[V_servo_duty_per_angle] * error;
    v[V_duty] = bridge_is_closed(m) ? fmin(fmax(duty, -limit), limit) : 0.0;
}

/* Classical Runge-Kutta steps of fourth order, the duration divided evenly. */
static void integrate(Model *m, double duration) {
    int steps = (int)fmax(1.0, ceil(duration / INTERNAL_STEP - 1e-6));
    double h = duration / steps;
    for (int i = 0; i < steps; ++i) {
        double q = m->position, w1 = m->velocity;
        double a1 = acceleration(m, q, w1);
        double w2 = w1 + 0.5 * h * a1, a2 = acceleration(m, q + 0.5 * h * w1, w2);
        double w3 = w1 + 0.5 * h * a2, a3 = acceleration(m, q + 0.5 * h * w2, w3);
        double w4 = w1 + h * a3, a4 = acceleration(m, q + h * w3, w4);
        m->position = q + h / 6.0 * (w1 + 2.0 * w2 + 2.0 * w3 + w4);
        m->velocity = w1 + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
    }
}

static const char *check_inertia(const Model *m) {
    return inertia(m->v) > 0.0
               ? NULL
               : "nothing turns: set 'motor.armature' or 'load.mass' and 'load.length' above 0";
}

const char *model_initialise(Model *m, const char *resources) {
    (void)resources;
    m->sampler.period = m->v[V_servo_sample_time];
    m->position = m->v[V_initial_position];
    m->velocity = m->v[V_initial_velocity];
    refresh_outputs(m);
    return check_inertia(m);
}

const char *model_step(Model *m, double t, double h) {
    double end = t + h;
    for (double now = t; now < end;) {
        if (sampler_due(&m->sampler, now)) control(m);
        m->v[V_voltage] = m->v[V_supply] * m->v[V_duty];
        double until = sampler_until(&m->sampler, end);
        integrate(m, until - now);
        now = until;
    }
    refresh_outputs(m);
    return isfinite(m->position) && isfinite(m->velocity) ? NULL : "the pendulum has diverged";
}

const char *model_parameter_changed(Model *m, int index) {
    (void)index; /* read again in every step */
    return check_inertia(m);
}
