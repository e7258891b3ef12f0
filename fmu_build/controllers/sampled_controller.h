/* The functions of model.h for a sampled controller. A controller's C file defines ControllerState
 * and control(), which computes v[V_u] from v[] at a sample instant, then includes this file. */
#include "model.h"
#include "sampling.h"

struct Model {
    double v[N_VARIABLES];
    Sampler sampler;
    ControllerState state;
};
const size_t model_bytes = sizeof(struct Model);

static const char *check_limits(const Model *m) {
    return m->v[V_u_min] <= m->v[V_u_max] ? NULL : "'u_min' is greater than 'u_max': set 'u_min' below 'u_max'";
}

const char *model_initialise(Model *m, const char *resources) {
    (void)resources;
    m->sampler.period = m->v[V_sample_time];
    m->v[V_u] = limited(0.0, m->v[V_u_min], m->v[V_u_max]);
    return check_limits(m);
}

const char *model_step(Model *m, double t, double h) {
    double end = t + h;
    for (double now = t; now < end; now = sampler_until(&m->sampler, end))
        if (sampler_due(&m->sampler, now)) control(m->v, &m->state);
    return NULL;
}

const char *model_parameter_changed(Model *m, int index) {
    (void)index;
    return check_limits(m);
}
