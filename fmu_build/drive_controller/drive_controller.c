/* Sampled position controller of a robot joint; its torque command goes to a drive. */
#include "position_controller.h"

struct Model {
    double v[N_VARIABLES];
    PositionController controller;
};
const size_t model_bytes = sizeof(struct Model);

const char *model_initialise(Model *m, const char *resources) {
    (void)resources;
    position_controller_initialise(&m->controller, m->v);
    return NULL;
}

const char *model_step(Model *m, double t, double h) {
    double end = t + h;
    for (double now = t; now < end;) {
        if (sampler_due(&m->controller.sampler, now))
            position_controller_sample(&m->controller, m->v, m->v[V_position], m->v[V_motor_position]);
        now = sampler_until(&m->controller.sampler, end);
    }
    return NULL;
}

const char *model_parameter_changed(Model *m, int index) {
    (void)m, (void)index;
    return NULL;
}
