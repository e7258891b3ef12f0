/* Rotary servo: one mass behind a current loop, under a sampled PD position controller. */
#include "control_laws.h"
#include "model.h"
#include "rotor.h"

struct Model {
    double v[N_VARIABLES];
    Sampler sampler;
    Rotor rotor;
    Derivative rate; /* [rad/s] of the reading */
};
const size_t model_bytes = sizeof(struct Model);

static double reading(const Model *m) { return m->rotor.position + m->v[V_encoder_offset]; }

static void refresh_outputs(Model *m) {
    m->v[V_position] = reading(m);
    m->v[V_true_position] = m->rotor.position;
    m->v[V_velocity] = m->rotor.velocity;
    m->v[V_torque] = m->rotor.torque;
}

/* tau*_k = sat(kp (r_k - y_k) - kd d_k), d the filtered difference of the reading. */
static void control(Model *m) {
    double *v = m->v;
    double measured = reading(m);
    double rate = derivative_next(&m->rate, measured, v[V_filter_time], v[V_sample_time]);
    v[V_torque_command] =
        limited(v[V_kp] * (v[V_reference] - measured) - v[V_kd] * rate, -v[V_torque_limit], v[V_torque_limit]);
}

const char *model_initialise(Model *m, const char *resources) {
    (void)resources;
    m->sampler.period = m->v[V_sample_time];
    m->rotor.position = m->v[V_initial_position];
    refresh_outputs(m);
    return NULL;
}

const char *model_step(Model *m, double t, double h) {
    const double *v = m->v;
    RotorParameters parameters = {v[V_inertia], v[V_viscous], 1.0 / v[V_torque_lag]};
    double end = t + h;
    for (double now = t; now < end;) {
        if (sampler_due(&m->sampler, now)) control(m);
        double until = sampler_until(&m->sampler, end);
        rotor_advance(&m->rotor, &parameters, v[V_torque_command] + v[V_tau_command], v[V_tau_load], until - now);
        now = until;
    }
    refresh_outputs(m);
    return isfinite(m->rotor.position) && isfinite(m->rotor.velocity) ? NULL : "the servo has diverged";
}

const char *model_parameter_changed(Model *m, int index) {
    (void)m, (void)index; /* read again in every step */
    return NULL;
}
