/* Entry of an augmented FMU. Every call goes on to the container's runtime, which is a library of
 * its own in the resources; three things are done here, since the runtime does them otherwise:
 *
 *   - start values are set when an instance is made and when it is reset. The runtime sets them in
 *     fmi2SetupExperiment, over whatever the tool has set before, as the standard allows it to;
 *   - communication steps that are no multiple of the internal step are refused. The runtime
 *     answers fmi2OK to them and holds old values;
 *   - what the runtime logs while an instance is made is told only if that fails or logging is on.
 *     It begins every instance with lines that it calls errors. */
#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2.h"
#include "library.h"
#include "resources.h"

#define CALLS(X) \
    X(fmi2Instantiate) X(fmi2FreeInstance) X(fmi2SetDebugLogging) X(fmi2SetupExperiment) \
    X(fmi2EnterInitializationMode) X(fmi2ExitInitializationMode) X(fmi2Terminate) X(fmi2Reset) \
    X(fmi2GetReal) X(fmi2GetInteger) X(fmi2GetBoolean) X(fmi2GetString) \
    X(fmi2SetReal) X(fmi2SetInteger) X(fmi2SetBoolean) X(fmi2SetString) \
    X(fmi2GetFMUstate) X(fmi2SetFMUstate) X(fmi2FreeFMUstate) X(fmi2SerializedFMUstateSize) \
    X(fmi2SerializeFMUstate) X(fmi2DeSerializeFMUstate) X(fmi2GetDirectionalDerivative) \
    X(fmi2SetRealInputDerivatives) X(fmi2GetRealOutputDerivatives) X(fmi2DoStep) \
    X(fmi2CancelStep) X(fmi2GetStatus) X(fmi2GetRealStatus) X(fmi2GetIntegerStatus) \
    X(fmi2GetBooleanStatus) X(fmi2GetStringStatus)

#define AS_INDEX(name) AT_##name,
#define AS_TEXT(name) #name,
enum { CALLS(AS_INDEX) N_CALLS };
static const char *const call_names[N_CALLS] = {CALLS(AS_TEXT)};

typedef struct {
    char type; /* R, I or B */
    fmi2ValueReference vr;
    double real;
    fmi2Integer whole;
} Start;

typedef struct {
    void *library;
    void *call[N_CALLS];
    fmi2Component inner;
    double step; /* [s] internal step */
    Start *starts;
    size_t n_starts;
    char *name;
    fmi2CallbackLogger logger;
    fmi2ComponentEnvironment environment;
    fmi2CallbackFunctions heard; /* what the runtime calls back */
    int telling;                 /* lines of the runtime are handed on */
    char held[2048];             /* those that were not */
} Front;

/* Calls a function of the runtime as what it is. */
#define RUNTIME(front, name, parameters) ((fmi2Status(*) parameters)(front)->call[AT_##name])

static void tell(const Front *front, const char *format, ...) {
    char line[2048];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    if (front->logger)
        front->logger(front->environment, front->name ? front->name : "", fmi2Error,
                      "logStatusError", "%s", line);
}

/* The logger that the runtime knows. */
static void hear(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status,
                 fmi2String category, fmi2String message, ...) {
    Front *front = environment;
    char line[1024];
    va_list arguments;
    va_start(arguments, message);
    vsnprintf(line, sizeof line, message, arguments);
    va_end(arguments);
    if (front->telling && front->logger) {
        front->logger(front->environment, instance, status, category, "%s", line);
    } else {
        size_t used = strlen(front->held);
        snprintf(front->held + used, sizeof front->held - used, "%s%s", used ? "; " : "", line);
    }
}

static char *copy_text(const char *text) {
    char *copy = malloc(strlen(text) + 1);
    return copy ? strcpy(copy, text) : NULL;
}

/* ---- start values ------------------------------------------------------------------------ */

static double double_of(const char *hexadecimal) {
    uint64_t bits = strtoull(hexadecimal, NULL, 16);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* Lines "S step", "R reference value", "I ...", "B ..."; doubles as their 64 bits in hexadecimal,
 * which no locale reads otherwise. */
static int read_starts(Front *front, const char *resources) {
    FILE *file = open_for_reading(resources, "starts.txt");
    if (!file) return 0;
    char line[128], value[64], type;
    unsigned int vr;
    int good = 1;
    while (good && fgets(line, sizeof line, file)) {
        good = sscanf(line, "%c %u %63s", &type, &vr, value) == 3;
        if (good && type == 'S') {
            front->step = double_of(value);
            continue;
        }
        Start *longer = good ? realloc(front->starts, (front->n_starts + 1) * sizeof *longer) : NULL;
        good = longer != NULL;
        if (good) {
            front->starts = longer;
            longer[front->n_starts++] = (Start){type, vr, type == 'R' ? double_of(value) : 0.0,
                                                type == 'R' ? 0 : (fmi2Integer)strtol(value, NULL, 10)};
        }
    }
    fclose(file);
    return good && front->step > 0.0;
}

static fmi2Status set_starts(Front *front) {
    fmi2Status worst = fmi2OK;
    for (size_t i = 0; i < front->n_starts; ++i) {
        const Start *start = &front->starts[i];
        fmi2Status status;
        if (start->type == 'R')
            status = RUNTIME(front, fmi2SetReal,
                             (fmi2Component, const fmi2ValueReference *, size_t, const fmi2Real *))(
                front->inner, &start->vr, 1, &start->real);
        else
            status = ((fmi2Status(*)(fmi2Component, const fmi2ValueReference *, size_t,
                                     const fmi2Integer *))
                          front->call[start->type == 'I' ? AT_fmi2SetInteger : AT_fmi2SetBoolean])(
                front->inner, &start->vr, 1, &start->whole);
        if (status > worst) worst = status;
    }
    if (worst > fmi2Warning) tell(front, "a start value was refused");
    return worst;
}

/* ---- instances --------------------------------------------------------------------------- */

FMI2_EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
FMI2_EXPORT const char *fmi2GetVersion(void) { return "2.0"; }

FMI2_EXPORT void fmi2FreeInstance(fmi2Component c) {
    Front *front = c;
    if (!front) return;
    if (front->inner)
        ((void (*)(fmi2Component))front->call[AT_fmi2FreeInstance])(front->inner);
    if (front->library) close_library(front->library);
    free(front->starts);
    free(front->name);
    free(front);
}

static int load_runtime(Front *front, const char *resources) {
    front->library = open_library(resources);
    if (!front->library) return 0;
    for (int i = 0; i < N_CALLS; ++i)
        if (!(front->call[i] = find_symbol(front->library, call_names[i]))) return 0;
    return 1;
}

FMI2_EXPORT fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid,
                                          fmi2String resource_location,
                                          const fmi2CallbackFunctions *functions,
                                          fmi2Boolean visible, fmi2Boolean logging) {
    Front *front = calloc(1, sizeof *front);
    char *resources = path_of_uri(resource_location ? resource_location : "");
    if (!front || !resources) {
        free(front);
        free(resources);
        return NULL;
    }
    front->name = copy_text(name ? name : "");
    front->logger = functions ? functions->logger : NULL;
    front->environment = functions ? functions->componentEnvironment : NULL;
    front->telling = logging;
    if (functions) front->heard = *functions;
    front->heard.logger = hear;
    front->heard.stepFinished = NULL; /* the runtime answers when a step is done */
    front->heard.componentEnvironment = front;
    const char *missing = NULL;
    if (!read_starts(front, resources))
        missing = "starts.txt";
    else if (!load_runtime(front, resources))
        missing = "the container's runtime for this system";
    if (missing) tell(front, "%s cannot be loaded from %s", missing, resources);
    free(resources);
    if (!missing) {
        front->inner = ((fmi2Component(*)(fmi2String, fmi2Type, fmi2String, fmi2String,
                                          const fmi2CallbackFunctions *, fmi2Boolean, fmi2Boolean))
                            front->call[AT_fmi2Instantiate])(name, type, guid, resource_location,
                                                             &front->heard, visible, logging);
        if (!front->inner) tell(front, "%s", front->held);
    }
    if (!front->inner || set_starts(front) > fmi2Warning) {
        fmi2FreeInstance(front);
        return NULL;
    }
    front->telling = 1;
    return front;
}

FMI2_EXPORT fmi2Status fmi2Reset(fmi2Component c) {
    Front *front = c;
    fmi2Status status = RUNTIME(front, fmi2Reset, (fmi2Component))(front->inner);
    fmi2Status set = status > fmi2Warning ? fmi2OK : set_starts(front);
    return set > status ? set : status;
}

FMI2_EXPORT fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_set_state) {
    Front *front = c;
    double steps = floor(h / front->step + 0.5);
    /* A tool adds up its times with its own rounding. */
    double tolerance = 1e-6 * front->step + 8.0 * DBL_EPSILON * fabs(t);
    if (!(steps >= 1.0) || fabs(h - steps * front->step) > tolerance) {
        tell(front, "a communication step of %.12g s is no multiple of the internal step of %.12g s",
             h, front->step);
        return fmi2Error;
    }
    return RUNTIME(front, fmi2DoStep, (fmi2Component, fmi2Real, fmi2Real, fmi2Boolean))(
        front->inner, t, h, no_set_state);
}

/* ---- handed on --------------------------------------------------------------------------- */

#define HAND_ON(name, parameters, arguments) \
    FMI2_EXPORT fmi2Status name parameters { \
        Front *front = c; \
        return RUNTIME(front, name, parameters) arguments; \
    }
#define GET(name, type) \
    HAND_ON(name, (fmi2Component c, const fmi2ValueReference vr[], size_t n, type value[]), \
            (front->inner, vr, n, value))
#define TELL(name, type) \
    HAND_ON(name, (fmi2Component c, const fmi2StatusKind kind, type *value), \
            (front->inner, kind, value))

GET(fmi2GetReal, fmi2Real)
GET(fmi2GetInteger, fmi2Integer)
GET(fmi2GetBoolean, fmi2Boolean)
GET(fmi2GetString, fmi2String)
GET(fmi2SetReal, const fmi2Real)
GET(fmi2SetInteger, const fmi2Integer)
GET(fmi2SetBoolean, const fmi2Boolean)
GET(fmi2SetString, const fmi2String)
TELL(fmi2GetStatus, fmi2Status)
TELL(fmi2GetRealStatus, fmi2Real)
TELL(fmi2GetIntegerStatus, fmi2Integer)
TELL(fmi2GetBooleanStatus, fmi2Boolean)
TELL(fmi2GetStringStatus, fmi2String)
HAND_ON(fmi2SetDebugLogging,
        (fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]),
        (front->inner, on, n, categories))
HAND_ON(fmi2SetupExperiment,
        (fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
         fmi2Boolean has_stop, fmi2Real stop),
        (front->inner, has_tolerance, tolerance, start, has_stop, stop))
HAND_ON(fmi2EnterInitializationMode, (fmi2Component c), (front->inner))
HAND_ON(fmi2ExitInitializationMode, (fmi2Component c), (front->inner))
HAND_ON(fmi2Terminate, (fmi2Component c), (front->inner))
HAND_ON(fmi2CancelStep, (fmi2Component c), (front->inner))
HAND_ON(fmi2GetFMUstate, (fmi2Component c, fmi2FMUstate *state), (front->inner, state))
HAND_ON(fmi2SetFMUstate, (fmi2Component c, fmi2FMUstate state), (front->inner, state))
HAND_ON(fmi2FreeFMUstate, (fmi2Component c, fmi2FMUstate *state), (front->inner, state))
HAND_ON(fmi2SerializedFMUstateSize, (fmi2Component c, fmi2FMUstate state, size_t *size),
        (front->inner, state, size))
HAND_ON(fmi2SerializeFMUstate,
        (fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size),
        (front->inner, state, bytes, size))
HAND_ON(fmi2DeSerializeFMUstate,
        (fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state),
        (front->inner, bytes, size, state))
HAND_ON(fmi2GetDirectionalDerivative,
        (fmi2Component c, const fmi2ValueReference unknown[], size_t n_unknown,
         const fmi2ValueReference known[], size_t n_known, const fmi2Real d_known[],
         fmi2Real d_unknown[]),
        (front->inner, unknown, n_unknown, known, n_known, d_known, d_unknown))
HAND_ON(fmi2SetRealInputDerivatives,
        (fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[],
         const fmi2Real value[]),
        (front->inner, vr, n, order, value))
HAND_ON(fmi2GetRealOutputDerivatives,
        (fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[],
         fmi2Real value[]),
        (front->inner, vr, n, order, value))
