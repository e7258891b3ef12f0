/* Servo drive of a robot joint: plant and sampled position controller in one FMU. */
#include "plant.h"
#include "position_controller.h"

struct Model {
    double v[N_VARIABLES];
    Plant plant;
    PositionController controller;
};
const size_t model_bytes = sizeof(struct Model);

static void refresh_outputs(Model *m) {
    double *v = m->v;
    plant_refresh_outputs(&m->plant, v);
    v[V_position] += v[V_encoder_offset];
    v[V_motor_position] += v[V_encoder_offset] + v[V_motor_encoder_offset];
}

const char *model_initialise(Model *m, const char *resources) {
    position_controller_initialise(&m->controller, m->v);
    const char *fault = plant_initialise(&m->plant, m->v, resources);
    if (!fault) refresh_outputs(m);
    return fault;
}

const char *model_step(Model *m, double t, double h) {
    double end = t + h;
    const char *fault = NULL;
    for (double now = t; now < end && !fault;) {
        if (sampler_due(&m->controller.sampler, now))
            position_controller_sample(&m->controller, m->v, plant_joint_reading(&m->plant, m->v),
                                       plant_motor_reading(&m->plant, m->v));
        double until = sampler_until(&m->controller.sampler, end);
        fault = plant_advance(&m->plant, m->v, now, until);
        now = until;
    }
    refresh_outputs(m);
    return fault;
}

const char *model_parameter_changed(Model *m, int index) {
    (void)index;
    plant_read_parameters(&m->plant, m->v);
    return NULL;
}
