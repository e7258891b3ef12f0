/* Servo drive of a robot joint below its torque command: current loop, motor, gear and load. */
#include "plant.h"

struct Model {
    double v[N_VARIABLES];
    Plant plant;
};
const size_t model_bytes = sizeof(struct Model);

const char *model_initialise(Model *m, const char *resources) {
    const char *fault = plant_initialise(&m->plant, m->v, resources);
    if (!fault) plant_refresh_outputs(&m->plant, m->v);
    return fault;
}

const char *model_step(Model *m, double t, double h) {
    const char *fault = plant_advance(&m->plant, m->v, t, t + h);
    plant_refresh_outputs(&m->plant, m->v);
    return fault;
}

const char *model_parameter_changed(Model *m, int index) {
    (void)index;
    plant_read_parameters(&m->plant, m->v);
    return NULL;
}
