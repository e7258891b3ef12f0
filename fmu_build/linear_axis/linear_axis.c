/* Linear servo axis (EMPS; Janot, Gautier, Brunot 2019): plant and sampled controller. */
#include <math.h>

#include "model.h"
#include "sampling.h"

static const double INTERNAL_STEP = 1e-4; /* [s] */

struct Model {
    double v[N_VARIABLES];
    Sampler sampler;
    double position, velocity;   /* [m], [m/s] states of the plant */
    double reading_1, reading_2; /* [m] encoder one and two samples ago */
};
const size_t model_bytes = sizeof(struct Model);

static void refresh_outputs(Model *m) {
    double *v = m->v;
    v[V_true_position] = m->position;
    v[V_position] = m->position + v[V_port_sensor];
    v[V_velocity] = m->velocity;
    v[V_force] = v[V_force_gain] * (v[V_drive_voltage] + v[V_port_command]);
}

/* vir = kv (kp (qg - qm) - dqf), where dqf is the difference of the mean of two readings. */
static void control(Model *m) {
    double *v = m->v;
    double reading = m->position + v[V_port_sensor];
    double rate = (reading - m->reading_2) / (2.0 * v[V_sample_time]);
    double command = v[V_kv] * (v[V_kp] * (v[V_reference] - reading) - rate);
    v[V_drive_voltage] = fmin(fmax(command, -v[V_voltage_limit]), v[V_voltage_limit]);
    m->reading_2 = m->reading_1;
    m->reading_1 = reading;
}

static double acceleration(const Model *m, double velocity) {
    const double *v = m->v;
    return (v[V_force] + v[V_port_force] - v[V_viscous_friction] * velocity) / v[V_mass];
}

/* Classical Runge-Kutta steps of fourth order, the duration divided evenly. */
static void integrate(Model *m, double duration) {
    int steps = (int)ceil(duration / INTERNAL_STEP - 1e-6);
    double h = duration / steps;
    for (int i = 0; i < steps; ++i) {
        double v1 = m->velocity, a1 = acceleration(m, v1);
        double v2 = v1 + 0.5 * h * a1, a2 = acceleration(m, v2);
        double v3 = v1 + 0.5 * h * a2, a3 = acceleration(m, v3);
        double v4 = v1 + h * a3, a4 = acceleration(m, v4);
        m->position += h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
        m->velocity += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
    }
}

const char *model_initialise(Model *m, const char *resources) {
    (void)resources;
    m->sampler.period = m->v[V_sample_time];
    m->position = m->v[V_initial_position];
    m->reading_1 = m->reading_2 = m->position + m->v[V_port_sensor];
    m->v[V_drive_voltage] = 0.0;
    refresh_outputs(m);
    return NULL;
}

const char *model_step(Model *m, double t, double h) {
    double end = t + h;
    for (double now = t; now < end;) {
        if (sampler_due(&m->sampler, now)) control(m);
        refresh_outputs(m);
        double until = sampler_until(&m->sampler, end);
        integrate(m, until - now);
        now = until;
    }
    refresh_outputs(m);
    return isfinite(m->position) && isfinite(m->velocity) ? NULL : "the axis has diverged";
}

const char *model_parameter_changed(Model *m, int index) {
    (void)m, (void)index;
    return NULL;
}
