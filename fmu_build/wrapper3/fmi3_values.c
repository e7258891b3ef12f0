/* Reading and setting variables by the calls of FMI 3.0. */
#include "fmi2_calls.h"
#include "front.h"

static int same_count(fmi3Instance c, size_t n, size_t n_values) {
    if (n == n_values) return 1;
    report(inner_of(c), fmi2Error, "%zu values for %zu variables: all of them are scalars", n_values, n);
    return 0;
}

FMI3_EXPORT fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                      const fmi3Float64 values[], size_t n_values) {
    return same_count(c, n, n_values) ? (fmi3Status)fmi2SetReal(inner_of(c), vr, n, values) : fmi3Error;
}

/* The value reference after the last is that of the time. */
FMI3_EXPORT fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float64 values[],
                                      size_t n_values) {
    if (!same_count(c, n, n_values)) return fmi3Error;
    fmi2Status worst = fmi2OK;
    for (size_t i = 0; i < n; ++i) {
        fmi2Status status = fmi2OK;
        if (vr[i] == N_VARIABLES) values[i] = inner_of(c)->progress.time;
        else status = fmi2GetReal(inner_of(c), &vr[i], 1, &values[i]);
        if (status > worst) worst = status;
    }
    return (fmi3Status)worst;
}

FMI3_EXPORT fmi3Status fmi3SetInt32(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Int32 values[],
                                    size_t n_values) {
    return same_count(c, n, n_values) ? (fmi3Status)fmi2SetInteger(inner_of(c), vr, n, values) : fmi3Error;
}

FMI3_EXPORT fmi3Status fmi3GetInt32(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Int32 values[],
                                    size_t n_values) {
    return same_count(c, n, n_values) ? (fmi3Status)fmi2GetInteger(inner_of(c), vr, n, values) : fmi3Error;
}

FMI3_EXPORT fmi3Status fmi3SetBoolean(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                      const fmi3Boolean values[], size_t n_values) {
    if (!same_count(c, n, n_values)) return fmi3Error;
    for (size_t i = 0; i < n; ++i) {
        fmi2Boolean value = values[i];
        fmi2Status status = fmi2SetBoolean(inner_of(c), &vr[i], 1, &value);
        if (status != fmi2OK) return (fmi3Status)status;
    }
    return fmi3OK;
}

FMI3_EXPORT fmi3Status fmi3GetBoolean(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Boolean values[],
                                      size_t n_values) {
    if (!same_count(c, n, n_values)) return fmi3Error;
    for (size_t i = 0; i < n; ++i) {
        fmi2Boolean value = 0;
        fmi2Status status = fmi2GetBoolean(inner_of(c), &vr[i], 1, &value);
        values[i] = value != 0;
        if (status != fmi2OK) return (fmi3Status)status;
    }
    return fmi3OK;
}

/* Types that no model of ours has. */
#define ABSENT_TYPE(TYPE)                                                                                   \
    FMI3_EXPORT fmi3Status fmi3Set##TYPE(fmi3Instance c, const fmi3ValueReference vr[], size_t n,             \
                                         const void *values, size_t n_values) {                              \
        (void)vr, (void)values, (void)n_values;                                                              \
        return n == 0 ? fmi3OK : not_provided(c, "fmi3Set" #TYPE);                                           \
    }                                                                                                        \
    FMI3_EXPORT fmi3Status fmi3Get##TYPE(fmi3Instance c, const fmi3ValueReference vr[], size_t n, void *values, \
                                         size_t n_values) {                                                  \
        (void)vr, (void)values, (void)n_values;                                                              \
        return n == 0 ? fmi3OK : not_provided(c, "fmi3Get" #TYPE);                                           \
    }

ABSENT_TYPE(Float32)
ABSENT_TYPE(Int8)
ABSENT_TYPE(UInt8)
ABSENT_TYPE(Int16)
ABSENT_TYPE(UInt16)
ABSENT_TYPE(UInt32)
ABSENT_TYPE(Int64)
ABSENT_TYPE(UInt64)
ABSENT_TYPE(String)
ABSENT_TYPE(Binary)
ABSENT_TYPE(Clock)
