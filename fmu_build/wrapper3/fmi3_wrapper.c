/* FMI 3.0 co-simulation in front of the FMI 2.0 wrapper: life of an instance and its steps. */
#include <stdlib.h>

#include "fmi2_calls.h"
#include "front.h"

enum { LINE_BYTES = 1024 };

/* The FMI 2.0 wrapper doubles each '%', since its messages are printf formats; these are none. */
static void forward(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                    fmi2String message, ...) {
    (void)name;
    const Front *front = environment;
    char line[LINE_BYTES];
    size_t used = 0;
    for (; *message && used + 1 < sizeof line; ++message) {
        line[used++] = *message;
        if (message[0] == '%' && message[1] == '%') ++message;
    }
    line[used] = '\0';
    if (front->log) front->log(front->environment, (fmi3Status)status, category, line);
}

fmi3Status not_provided(fmi3Instance c, const char *call) {
    return (fmi3Status)report(inner_of(c), fmi2Error, "%s is not provided: this FMU is for co-simulation without events", call);
}

/* ---- life of an instance --------------------------------------------------------------- */

FMI3_EXPORT const char *fmi3GetVersion(void) { return "3.0"; }

FMI3_EXPORT void fmi3FreeInstance(fmi3Instance c) {
    Front *front = c;
    if (!front) return;
    fmi2FreeInstance(front->inner);
    free(front);
}

FMI3_EXPORT fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                                     fmi3Boolean visible, fmi3Boolean logging,
                                                     fmi3Boolean event_mode, fmi3Boolean early_return,
                                                     const fmi3ValueReference required[], size_t n_required,
                                                     fmi3InstanceEnvironment environment,
                                                     fmi3LogMessageCallback log,
                                                     fmi3IntermediateUpdateCallback update) {
    (void)early_return, (void)required, (void)n_required, (void)update;
    Front *front = calloc(1, sizeof *front);
    if (!front) return NULL;
    front->log = log;
    front->environment = environment;
    if (event_mode) {
        forward(front, name, fmi2Error, "logStatusError", "event mode is not provided");
    } else {
        fmi2CallbackFunctions functions = {.logger = forward, .componentEnvironment = front};
        front->inner = fmi2Instantiate(name, fmi2CoSimulation, token, resources, &functions, visible, logging);
    }
    if (front->inner) return front;
    free(front);
    return NULL;
}

FMI3_EXPORT fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean logging, size_t n, const fmi3String categories[]) {
    return (fmi3Status)fmi2SetDebugLogging(inner_of(c), logging, n, categories);
}

FMI3_EXPORT fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean with_tolerance, fmi3Float64 tolerance,
                                                   fmi3Float64 start, fmi3Boolean with_stop, fmi3Float64 stop) {
    fmi2Status status = fmi2SetupExperiment(inner_of(c), with_tolerance, tolerance, start, with_stop, stop);
    return (fmi3Status)(status == fmi2OK ? fmi2EnterInitializationMode(inner_of(c)) : status);
}

FMI3_EXPORT fmi3Status fmi3ExitInitializationMode(fmi3Instance c) {
    return (fmi3Status)fmi2ExitInitializationMode(inner_of(c));
}

FMI3_EXPORT fmi3Status fmi3Terminate(fmi3Instance c) { return (fmi3Status)fmi2Terminate(inner_of(c)); }
FMI3_EXPORT fmi3Status fmi3Reset(fmi3Instance c) { return (fmi3Status)fmi2Reset(inner_of(c)); }

/* ---- steps ----------------------------------------------------------------------------- */

FMI3_EXPORT fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no_set_state,
                                  fmi3Boolean *event_needed, fmi3Boolean *terminate, fmi3Boolean *early_return,
                                  fmi3Float64 *last_time) {
    *event_needed = *terminate = *early_return = false;
    fmi2Status status = fmi2DoStep(inner_of(c), t, h, no_set_state);
    *last_time = inner_of(c)->progress.time;
    return (fmi3Status)status;
}

/* ---- states ---------------------------------------------------------------------------- */

FMI3_EXPORT fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state) {
    return (fmi3Status)fmi2GetFMUstate(inner_of(c), state);
}

FMI3_EXPORT fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) {
    return (fmi3Status)fmi2SetFMUstate(inner_of(c), state);
}

FMI3_EXPORT fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state) {
    return (fmi3Status)fmi2FreeFMUstate(inner_of(c), state);
}

FMI3_EXPORT fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *bytes) {
    return (fmi3Status)fmi2SerializedFMUstateSize(inner_of(c), state, bytes);
}

FMI3_EXPORT fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
    return (fmi3Status)fmi2SerializeFMUstate(inner_of(c), state, (fmi2Byte *)bytes, size);
}

FMI3_EXPORT fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size, fmi3FMUState *state) {
    return (fmi3Status)fmi2DeSerializeFMUstate(inner_of(c), (const fmi2Byte *)bytes, size, state);
}
