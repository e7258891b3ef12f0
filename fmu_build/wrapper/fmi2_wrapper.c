/* FMI 2.0 co-simulation around any model of model.h: life of an instance and its steps. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "instance.h"
#include "resources.h"

void restore_start(Instance *instance) {
    memset(instance->model, 0, model_bytes);
    for (int i = 0; i < N_VARIABLES; ++i) values_of(instance)[i] = model_variables[i].start;
    instance->progress = (Progress){.phase = PHASE_INSTANTIATED};
}

fmi2Status initialise_model(Instance *instance) {
    double *v = values_of(instance);
    for (int i = 0; i < N_VARIABLES; ++i)
        if (model_variables[i].causality >= CAUSALITY_OUTPUT) v[i] = model_variables[i].start;
    memset(v + N_VARIABLES, 0, model_bytes - N_VARIABLES * sizeof *v);
    fmi2Status status = status_of(instance, model_initialise(instance->model, instance->resources));
    if (status >= fmi2Discard) {
        instance->progress.phase = PHASE_FAILED;
        return fmi2Error;
    }
    instance->progress.outputs_stale = 0;
    return status;
}

static char *copy_text(const char *text) {
    char *copy = malloc(strlen(text) + 1);
    return copy ? strcpy(copy, text) : NULL;
}

/* ---- life of an instance --------------------------------------------------------------- */

FMI2_EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
FMI2_EXPORT const char *fmi2GetVersion(void) { return "2.0"; }

FMI2_EXPORT void fmi2FreeInstance(fmi2Component c) {
    Instance *instance = c;
    if (!instance) return;
    free(instance->model);
    free(instance->name);
    free(instance->resources);
    free(instance);
}

FMI2_EXPORT fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid,
                                          fmi2String resource_location,
                                          const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                                          fmi2Boolean logging) {
    (void)visible;
    Instance *instance = calloc(1, sizeof *instance);
    if (!instance) return NULL;
    instance->logger = functions ? functions->logger : NULL;
    instance->environment = functions ? functions->componentEnvironment : NULL;
    instance->logging = logging;
    instance->name = copy_text(name && *name ? name : model_name);
    instance->resources = path_of_uri(resource_location ? resource_location : "");
    instance->model = malloc(model_bytes);
    if (!instance->name || !instance->resources || !instance->model) {
        fmi2FreeInstance(instance);
        return NULL;
    }
    const char *fault = NULL;
    if (type != fmi2CoSimulation) fault = "only co-simulation is provided";
    if (!guid || strcmp(guid, model_guid) != 0) fault = "the guid differs from that of the model description";
    if (fault) {
        report(instance, fmi2Error, "%s cannot be instantiated: %s", model_name, fault);
        fmi2FreeInstance(instance);
        return NULL;
    }
    restore_start(instance);
    return instance;
}

FMI2_EXPORT fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean logging, size_t n,
                                           const fmi2String categories[]) {
    (void)n, (void)categories;
    ((Instance *)c)->logging = logging;
    return fmi2OK;
}

static fmi2Status expect_phase(const Instance *instance, int phase, const char *call) {
    if (instance->progress.phase == phase) return fmi2OK;
    return report(instance, fmi2Error, "%s is not allowed in this phase of the simulation", call);
}

FMI2_EXPORT fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean with_tolerance, fmi2Real tolerance,
                                           fmi2Real start, fmi2Boolean with_stop, fmi2Real stop) {
    (void)with_tolerance, (void)tolerance, (void)with_stop, (void)stop;
    Instance *instance = c;
    fmi2Status status = expect_phase(instance, PHASE_INSTANTIATED, "fmi2SetupExperiment");
    if (status != fmi2OK) return status;
    if (!isfinite(start)) return report(instance, fmi2Error, "the start time %g s is not finite", start);
    instance->progress.time = start;
    return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    Instance *instance = c;
    fmi2Status status = expect_phase(instance, PHASE_INSTANTIATED, "fmi2EnterInitializationMode");
    if (status != fmi2OK) return status;
    instance->progress.phase = PHASE_INITIALISING;
    instance->progress.outputs_stale = 1;
    return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    Instance *instance = c;
    fmi2Status status = expect_phase(instance, PHASE_INITIALISING, "fmi2ExitInitializationMode");
    if (status != fmi2OK) return status;
    if (instance->progress.outputs_stale) status = initialise_model(instance);
    if (status < fmi2Discard) instance->progress.phase = PHASE_STEPPING;
    return status;
}

FMI2_EXPORT fmi2Status fmi2Terminate(fmi2Component c) {
    Instance *instance = c;
    fmi2Status status = expect_phase(instance, PHASE_STEPPING, "fmi2Terminate");
    if (status == fmi2OK) instance->progress.phase = PHASE_TERMINATED;
    return status;
}

FMI2_EXPORT fmi2Status fmi2Reset(fmi2Component c) {
    restore_start(c);
    return fmi2OK;
}

/* ---- steps ----------------------------------------------------------------------------- */

/* A master that adds up steps drifts by rounding; that is still the same communication point. */
static int same_time(double a, double b, double h) { return fabs(a - b) <= 1e-6 * h + 1e-9 * fabs(b); }

FMI2_EXPORT fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_set_state) {
    (void)no_set_state;
    Instance *instance = c;
    Progress *progress = &instance->progress;
    fmi2Status status = expect_phase(instance, PHASE_STEPPING, "fmi2DoStep");
    if (status != fmi2OK) return status;
    if (!(h > 0.0) || !isfinite(h))
        return report(instance, fmi2Error, "the communication step must be positive, got %g s", h);
    if (!same_time(t, progress->time, h))
        return report(instance, fmi2Error, "a step from %.15g s was asked for, but the model stands at %.15g s", t,
                      progress->time);
    status = status_of(instance, model_step(instance->model, t, h));
    if (status >= fmi2Error) progress->phase = PHASE_FAILED;
    if (status <= fmi2Warning) progress->time = t + h;
    return status;
}

FMI2_EXPORT fmi2Status fmi2CancelStep(fmi2Component c) {
    return report(c, fmi2Error, "steps are synchronous: there is none to cancel");
}

FMI2_EXPORT fmi2Status fmi2GetRealStatus(fmi2Component c, fmi2StatusKind kind, fmi2Real *value) {
    if (kind != fmi2LastSuccessfulTime) return fmi2Discard;
    *value = ((Instance *)c)->progress.time;
    return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2GetBooleanStatus(fmi2Component c, fmi2StatusKind kind, fmi2Boolean *value) {
    (void)c;
    if (kind != fmi2Terminated) return fmi2Discard;
    *value = fmi2False; /* no model asks the master to end the simulation */
    return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2GetStatus(fmi2Component c, fmi2StatusKind kind, fmi2Status *value) {
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}

FMI2_EXPORT fmi2Status fmi2GetIntegerStatus(fmi2Component c, fmi2StatusKind kind, fmi2Integer *value) {
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}

FMI2_EXPORT fmi2Status fmi2GetStringStatus(fmi2Component c, fmi2StatusKind kind, fmi2String *value) {
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}

/* ---- what is not provided -------------------------------------------------------------- */

FMI2_EXPORT fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                                   const fmi2Integer order[], const fmi2Real value[]) {
    (void)vr, (void)order, (void)value;
    return n == 0 ? fmi2OK : report(c, fmi2Error, "inputs are held: derivatives of inputs are not used");
}

FMI2_EXPORT fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                                    const fmi2Integer order[], fmi2Real value[]) {
    (void)vr, (void)order, (void)value;
    return n == 0 ? fmi2OK : report(c, fmi2Error, "derivatives of outputs are not provided");
}

FMI2_EXPORT fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[],
                                                    size_t n_unknown, const fmi2ValueReference known[],
                                                    size_t n_known, const fmi2Real seed[],
                                                    fmi2Real sensitivity[]) {
    (void)unknown, (void)n_unknown, (void)known, (void)n_known, (void)seed, (void)sensitivity;
    return report(c, fmi2Error, "directional derivatives are not provided");
}
