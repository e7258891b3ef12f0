/* FMI 3.0 by hand, for the tests: an input and an output of each type, and a step that asks for what a
 * master at fixed points cannot give. It exports what it needs and nothing else, as some vendors do. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fmi3.h"

enum { OUTPUTS = 100, DEMAND = 200, AT = 201, VECTOR = 300, ROOM = 400 };
enum { NOTHING, EVENT, TERMINATE, EARLY_RETURN, NAN_FLOAT32, WARNING, ERROR };

#define EACH_TYPE(CASE)                                                                       \
    CASE(Float64, double) CASE(Float32, float) CASE(Int8, int8_t) CASE(UInt8, uint8_t)          \
    CASE(Int16, int16_t) CASE(UInt16, uint16_t) CASE(Int32, int32_t) CASE(UInt32, uint32_t)     \
    CASE(Int64, int64_t) CASE(UInt64, uint64_t) CASE(Boolean, bool)

typedef struct {
#define CASE(TYPE, C_TYPE) C_TYPE TYPE[ROOM];
    EACH_TYPE(CASE)
#undef CASE
    fmi3LogMessageCallback log;
    fmi3InstanceEnvironment environment;
} Types;

#define CASE(TYPE, C_TYPE)                                                                            \
    FMI3_EXPORT fmi3Status fmi3Set##TYPE(fmi3Instance c, const fmi3ValueReference vr[], size_t n,      \
                                         const C_TYPE values[], size_t n_values) {                    \
        if (n != n_values) return fmi3Error;                                                          \
        for (size_t i = 0; i < n; ++i) ((Types *)c)->TYPE[vr[i]] = values[i];                         \
        return fmi3OK;                                                                                \
    }                                                                                                 \
    FMI3_EXPORT fmi3Status fmi3Get##TYPE(fmi3Instance c, const fmi3ValueReference vr[], size_t n,      \
                                         C_TYPE values[], size_t n_values) {                          \
        if (n != n_values) return fmi3Error;                                                          \
        for (size_t i = 0; i < n; ++i) values[i] = ((Types *)c)->TYPE[vr[i]];                         \
        return fmi3OK;                                                                                \
    }
EACH_TYPE(CASE)
#undef CASE

FMI3_EXPORT const char *fmi3GetVersion(void) { return "3.0"; }
FMI3_EXPORT void fmi3FreeInstance(fmi3Instance c) { free(c); }

FMI3_EXPORT fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                                     fmi3Boolean visible, fmi3Boolean logging,
                                                     fmi3Boolean event_mode, fmi3Boolean early_return,
                                                     const fmi3ValueReference required[], size_t n_required,
                                                     fmi3InstanceEnvironment environment,
                                                     fmi3LogMessageCallback log,
                                                     fmi3IntermediateUpdateCallback update) {
    (void)name, (void)resources, (void)visible, (void)logging, (void)required, (void)n_required, (void)update;
    Types *types = event_mode || early_return ? NULL : calloc(1, sizeof *types);
    if (types) types->log = log, types->environment = environment;
    if (strcmp(token, "fmi3_types") == 0) return types;
    if (log) log(environment, fmi3Error, "logStatusError", "the instantiation token is another");
    free(types);
    return NULL;
}

FMI3_EXPORT fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean with_tolerance, fmi3Float64 tolerance,
                                                   fmi3Float64 start, fmi3Boolean with_stop, fmi3Float64 stop) {
    (void)c, (void)with_tolerance, (void)tolerance, (void)start, (void)stop;
    return with_stop ? fmi3Error : fmi3OK;
}

FMI3_EXPORT fmi3Status fmi3ExitInitializationMode(fmi3Instance c) {
    (void)c;
    return fmi3OK;
}

static fmi3Status answer(Types *types, int demand, fmi3Boolean *event_needed, fmi3Boolean *terminate,
                         fmi3Boolean *early_return) {
    *event_needed = demand == EVENT;
    *terminate = demand == TERMINATE;
    *early_return = demand == EARLY_RETURN;
    if (demand == NAN_FLOAT32) types->Float32[OUTPUTS + 2] = NAN;
    if (demand == WARNING) return fmi3Warning;
    if (demand != ERROR) return fmi3OK;
    if (types->log) types->log(types->environment, fmi3Error, "logStatusError", "100 % asked for");
    return fmi3Error;
}

/* Each output is the input of its type as it was set before the step. */
FMI3_EXPORT fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no_set_state,
                                  fmi3Boolean *event_needed, fmi3Boolean *terminate, fmi3Boolean *early_return,
                                  fmi3Float64 *last_time) {
    (void)no_set_state;
    Types *types = c;
#define CASE(TYPE, C_TYPE) memcpy(&types->TYPE[OUTPUTS], types->TYPE, OUTPUTS * sizeof(C_TYPE));
    EACH_TYPE(CASE)
#undef CASE
    *last_time = t + h;
    int due = t + h >= types->Float64[AT] - 1e-9;
    return answer(types, due ? types->Int32[DEMAND] : NOTHING, event_needed, terminate, early_return);
}
