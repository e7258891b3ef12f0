/* Passes its input on. */
#include "model.h"

struct Model {
    double v[N_VARIABLES];
};
const size_t model_bytes = sizeof(struct Model);

const char *model_initialise(Model *m, const char *resources) {
    (void)resources;
    m->v[V_position] = m->v[V_reference];
    return NULL;
}

const char *model_step(Model *m, double t, double h) {
    (void)t, (void)h;
    m->v[V_position] = m->v[V_reference];
    return NULL;
}

const char *model_parameter_changed(Model *m, int index) {
    (void)m, (void)index;
    return NULL;
}
