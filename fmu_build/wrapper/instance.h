/* One instance of an FMU, shared by the files of the wrapper. */
#ifndef GMFBO_INSTANCE_H
#define GMFBO_INSTANCE_H

#include "fmi2.h"
#include "model.h"

typedef enum {
    PHASE_INSTANTIATED,
    PHASE_INITIALISING,
    PHASE_STEPPING,
    PHASE_TERMINATED,
    PHASE_FAILED /* after an error in a step: only reset, free and reading remain */
} Phase;

/* All that an FMU state restores. */
typedef struct {
    int phase;
    int outputs_stale; /* initialising: a value was set since the outputs were computed */
    double time; /* [s] current communication point */
} Progress;

typedef struct {
    Progress progress;
    Model *model;
    char *name;
    char *resources;
    fmi2CallbackLogger logger;
    fmi2ComponentEnvironment environment;
    int logging;
} Instance;

static inline double *values_of(const Instance *instance) { return (double *)instance->model; }

/* Sets v[] to the start values and the states to zero. */
void restore_start(Instance *instance);

/* Computes states and outputs from the parameters and inputs in v[]. */
fmi2Status initialise_model(Instance *instance);

/* Hands one printf-formatted line to the environment and returns `status`; fmi2OK is an event, told
 * only while debug logging is on. */
#if defined(__GNUC__)
__attribute__((format(printf, 3, 4)))
#endif
fmi2Status report(const Instance *instance, fmi2Status status, const char *format, ...);

/* Status that a model's answer stands for, reported if it is not NULL. */
fmi2Status status_of(const Instance *instance, const char *answer);

#endif
