/* Fails as its parameter `fault` says, so that the driver's answer to each failure can be tested. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "model.h"

struct Model {
    double v[N_VARIABLES];
};
const size_t model_bytes = sizeof(struct Model);

enum { INITIALISATION = 1, STEP = 2 };
enum { SEGMENTATION_FAULT = 1, EXIT, HANG, NOT_A_NUMBER, DISCARD, ERROR, ABORT, PRINT, WARNING };

static const char *fail(Model *m) {
    int *volatile nowhere = NULL; /* volatile, or the compiler puts a trap in place of the write */
    switch ((int)m->v[V_fault]) {
    case SEGMENTATION_FAULT: *nowhere = 1; return NULL;
    case EXIT: exit(0);
    case HANG:
        for (volatile int spin = 0;; spin = !spin) {
        }
    case NOT_A_NUMBER: m->v[V_position] = NAN; return NULL;
    case DISCARD: return "discard: asked for by parameter 'fault'";
    case ERROR: return "asked for by parameter 'fault'";
    case ABORT: abort();
    case PRINT:
        puts("faulty prints to standard output");
        fflush(stdout);
        return NULL;
    case WARNING: return "warning: asked for by parameter 'fault'";
    default: return NULL;
    }
}

const char *model_initialise(Model *m, const char *resources) {
    (void)resources;
    m->v[V_position] = m->v[V_gain] * m->v[V_reference];
    return m->v[V_stage] == INITIALISATION ? fail(m) : NULL;
}

const char *model_step(Model *m, double t, double h) {
    m->v[V_position] = m->v[V_gain] * m->v[V_reference];
    return m->v[V_stage] == STEP && t >= m->v[V_at] - 1e-6 * h ? fail(m) : NULL;
}

const char *model_parameter_changed(Model *m, int index) {
    (void)m, (void)index;
    return NULL;
}
