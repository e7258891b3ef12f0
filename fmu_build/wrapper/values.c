/* Reading and setting variables; a refused value is named with its bounds and changes nothing. */
#include <math.h>

#include "instance.h"

static const char *const TYPE_NAMES[] = {"Real", "Integer", "Boolean"};

static fmi2Status check_reference(const Instance *instance, fmi2ValueReference reference,
                                  VariableType type) {
    if (reference >= N_VARIABLES)
        return report(instance, fmi2Error, "%s has no variable with value reference %u: expected 0 to %d",
                      model_name, reference, N_VARIABLES - 1);
    const Variable *variable = &model_variables[reference];
    if (variable->type != type)
        return report(instance, fmi2Error, "'%s' is of type %s and was accessed as %s", variable->name,
                      TYPE_NAMES[variable->type], TYPE_NAMES[type]);
    return fmi2OK;
}

static fmi2Status check_may_set(const Instance *instance, const Variable *variable) {
    int phase = instance->progress.phase;
    if (phase == PHASE_FAILED || phase == PHASE_TERMINATED)
        return report(instance, fmi2Error, "'%s' cannot be set after the simulation has ended: reset first",
                      variable->name);
    if (variable->causality == CAUSALITY_OUTPUT || variable->causality == CAUSALITY_LOCAL)
        return report(instance, fmi2Error, "'%s' is computed by the model and cannot be set", variable->name);
    if (variable->causality == CAUSALITY_PARAMETER && phase == PHASE_STEPPING && !variable->tunable)
        return report(instance, fmi2Error, "parameter '%s' is fixed: set it before initialisation ends",
                      variable->name);
    return fmi2OK;
}

static fmi2Status check_value(const Instance *instance, const Variable *variable, double value) {
    if (isfinite(value) && value >= variable->min && value <= variable->max) return fmi2OK;
    return report(instance, fmi2Error, "'%s' = %.15g %s is refused: expected a value from %.15g to %.15g",
                  variable->name, value, variable->unit, variable->min, variable->max);
}

static fmi2Status check_set(const Instance *instance, fmi2ValueReference reference, VariableType type,
                            double value) {
    fmi2Status status = check_reference(instance, reference, type);
    if (status == fmi2OK) status = check_may_set(instance, &model_variables[reference]);
    if (status == fmi2OK) status = check_value(instance, &model_variables[reference], value);
    return status;
}

/* A parameter that changes between two steps is announced to the model, which may refuse it. */
static fmi2Status store(Instance *instance, fmi2ValueReference reference, double value) {
    double *v = values_of(instance);
    if (v[reference] == value) return fmi2OK;
    double before = v[reference];
    v[reference] = value;
    if (instance->progress.phase == PHASE_INITIALISING) instance->progress.outputs_stale = 1;
    if (instance->progress.phase != PHASE_STEPPING ||
        model_variables[reference].causality != CAUSALITY_PARAMETER)
        return fmi2OK;
    fmi2Status status = status_of(instance, model_parameter_changed(instance->model, (int)reference));
    if (status >= fmi2Discard) v[reference] = before;
    report(instance, fmi2OK, "'%s' = %.15g from %.15g s on", model_variables[reference].name, v[reference],
           instance->progress.time);
    return status;
}

/* While initialising, outputs follow the values set so far. */
static fmi2Status refresh_outputs(Instance *instance) {
    if (instance->progress.phase != PHASE_INITIALISING || !instance->progress.outputs_stale) return fmi2OK;
    return initialise_model(instance);
}

#define SET_AND_GET(TYPE_NAME, C_TYPE, TYPE, FROM_DOUBLE)                                              \
    FMI2_EXPORT fmi2Status fmi2Set##TYPE_NAME(fmi2Component c, const fmi2ValueReference vr[], size_t n, \
                                              const C_TYPE value[]) {                                 \
        Instance *instance = c;                                                                       \
        fmi2Status worst = fmi2OK;                                                                    \
        for (size_t i = 0; i < n; ++i)                                                                \
            if (check_set(instance, vr[i], TYPE, (double)value[i]) != fmi2OK) return fmi2Error;       \
        for (size_t i = 0; i < n; ++i) {                                                              \
            fmi2Status status = store(instance, vr[i], (double)value[i]);                             \
            if (status > worst) worst = status;                                                       \
        }                                                                                             \
        return worst;                                                                                 \
    }                                                                                                 \
    FMI2_EXPORT fmi2Status fmi2Get##TYPE_NAME(fmi2Component c, const fmi2ValueReference vr[], size_t n, \
                                              C_TYPE value[]) {                                       \
        Instance *instance = c;                                                                       \
        fmi2Status status = refresh_outputs(instance);                                                \
        if (status >= fmi2Discard) return status;                                                     \
        const double *v = values_of(instance);                                                        \
        for (size_t i = 0; i < n; ++i) {                                                              \
            if (check_reference(instance, vr[i], TYPE) != fmi2OK) return fmi2Error;                   \
            value[i] = FROM_DOUBLE(v[vr[i]]);                                                         \
        }                                                                                             \
        return status;                                                                                \
    }

#define AS_REAL(x) (x)
#define AS_INTEGER(x) ((fmi2Integer)(x))
#define AS_BOOLEAN(x) ((x) != 0.0)

SET_AND_GET(Real, fmi2Real, TYPE_REAL, AS_REAL)
SET_AND_GET(Integer, fmi2Integer, TYPE_INTEGER, AS_INTEGER)
SET_AND_GET(Boolean, fmi2Boolean, TYPE_BOOLEAN, AS_BOOLEAN)

FMI2_EXPORT fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                     const fmi2String value[]) {
    (void)vr, (void)value;
    return n == 0 ? fmi2OK : report(c, fmi2Error, "%s has no variables of type String", model_name);
}

FMI2_EXPORT fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                     fmi2String value[]) {
    (void)vr, (void)value;
    return n == 0 ? fmi2OK : report(c, fmi2Error, "%s has no variables of type String", model_name);
}
