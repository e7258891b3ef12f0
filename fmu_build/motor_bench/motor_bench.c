/* A motor on a bench, without a controller: a current accelerates one mass. What a drive logs of
 * the current may be filtered; the filter is exact for a current that is held over a step. */
#include "model.h"
#include "rotor.h"

struct Model {
    double v[N_VARIABLES];
    Rotor rotor;
};
const size_t model_bytes = sizeof(struct Model);

static void refresh_outputs(Model *m) {
    m->v[V_position] = m->rotor.position;
    m->v[V_velocity] = m->rotor.velocity;
}

const char *model_initialise(Model *m, const char *resources) {
    (void)resources;
    m->rotor.position = m->v[V_initial_position];
    m->rotor.velocity = m->v[V_initial_velocity];
    m->v[V_logged_current] = m->v[V_initial_logged_current];
    refresh_outputs(m);
    return NULL;
}

const char *model_step(Model *m, double t, double h) {
    (void)t;
    RotorParameters parameters = {m->v[V_inertia], m->v[V_viscous], 0.0};
    m->rotor.torque = m->v[V_torque_constant] * m->v[V_current];
    rotor_advance(&m->rotor, &parameters, 0.0, m->v[V_tau_load], h);
    m->v[V_motor_current] = m->v[V_current];
    double share = m->v[V_log_time] > 0.0 ? -expm1(-h / m->v[V_log_time]) : 1.0;
    m->v[V_logged_current] += share * (m->v[V_current] - m->v[V_logged_current]);
    refresh_outputs(m);
    return isfinite(m->rotor.position) && isfinite(m->rotor.velocity) ? NULL : "the motor has diverged";
}

const char *model_parameter_changed(Model *m, int index) {
    (void)m, (void)index; /* read again in every step */
    return NULL;
}
