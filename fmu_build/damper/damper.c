/* Damper on a test machine: the velocity of its rod is given, its force is the answer. No inertia:
 * the machine moves the rod, so that a force on it changes the force alone. */
#include <math.h>

#include "model.h"

struct Model {
    double v[N_VARIABLES];
    double position; /* [m] */
};
const size_t model_bytes = sizeof(struct Model);

static void refresh_outputs(Model *m) {
    double *v = m->v;
    v[V_rod_velocity] = v[V_velocity];
    v[V_position] = m->position;
    v[V_force] = v[V_port_force] - v[V_viscous] * v[V_velocity];
}

const char *model_initialise(Model *m, const char *resources) {
    (void)resources;
    m->position = m->v[V_initial_position];
    refresh_outputs(m);
    return NULL;
}

/* The velocity is held over the step: its integral is exact at any length. */
const char *model_step(Model *m, double t, double h) {
    (void)t;
    m->position += h * m->v[V_velocity];
    refresh_outputs(m);
    return isfinite(m->position) && isfinite(m->v[V_force]) ? NULL : "the damper has diverged";
}

const char *model_parameter_changed(Model *m, int index) {
    (void)m, (void)index; /* read again in every step */
    return NULL;
}
