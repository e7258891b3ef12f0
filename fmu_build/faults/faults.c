/* A gain as an FMI 2.0 co-simulation FMU with one fault, named by its guid up to the first '-'. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "fmi2.h"
#include "hostile.h"
#include "variables.h"

typedef struct {
    const fmi2CallbackFunctions *functions;
    double value[N_VARIABLES];
    double time, state; /* `state` counts steps and survives a reset that does not reset */
    double stop;
} Instance;

static char fault[64];
static int instances_made, instances_alive;

static int is(const char *name) { return strcmp(fault, name) == 0; }

static void crash(void) {
    int *volatile nowhere = NULL; /* volatile, or the compiler puts a trap in place of the write */
    *nowhere = 1;
}

static void hang(void) {
    for (volatile int spin = 0;; spin = !spin) {
    }
}

static fmi2Status report(const Instance *instance, fmi2Status status, const char *line) {
    const fmi2CallbackFunctions *functions = instance->functions;
    if (functions && functions->logger)
        functions->logger(functions->componentEnvironment, "fault", status, "logStatus", line);
    return status;
}

/* Touches memory that is never given back. */
static void leak(size_t bytes) {
    volatile char *lost = malloc(bytes); /* volatile, or the compiler leaves it all out */
    for (size_t i = 0; i < bytes; i += 1024) lost[i] = 1; /* crashes at last: it does not look */
}

#if defined(SEGFAULT_ON_LOAD) || defined(EXIT_ON_LOAD) || defined(HANG_ON_LOAD)
__attribute__((constructor)) static void on_load(void) {
#ifdef SEGFAULT_ON_LOAD
    crash();
#elif defined(EXIT_ON_LOAD)
    exit(7);
#else
    hang();
#endif
}
#endif

#ifdef NEEDS_ABSENT
extern int gmfbo_absent(void);
#endif

/* ---- life of an instance --------------------------------------------------------------- */

static void start(Instance *instance) {
    for (int i = 0; i < N_VARIABLES; ++i) instance->value[i] = 0.0;
    instance->value[V_gain] = 1.0;
    instance->value[V_at] = 0.05;
    instance->stop = INFINITY;
}

FMI2_EXPORT fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                          const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                                          fmi2Boolean logging) {
    (void)name, (void)type, (void)resources, (void)visible, (void)logging;
#ifdef NEEDS_ABSENT
    if (gmfbo_absent()) return NULL;
#endif
    snprintf(fault, sizeof fault, "%.*s", (int)strcspn(guid, "-"), guid);
    if (is("segfault_on_instantiate") || (is("dies_on_second_instance") && instances_made)) crash();
    if (is("exit_on_instantiate")) exit(0);
    if (is("hang_on_instantiate")) hang();
    Instance *instance = calloc(1, sizeof *instance);
    if (!instance) return NULL;
    instance->functions = functions;
    if (is("refuses_second_instance") && instances_alive) {
        report(instance, fmi2Error, "there is an instance already");
        free(instance);
        return NULL;
    }
    start(instance);
    ++instances_made;
    ++instances_alive;
    if (is("leak_each_instance")) leak((size_t)8 << 20);
    if (is("changes_folder") && chdir("/") != 0) return NULL;
    if (is("closes_files"))
        for (int file = 0; file < 1024; ++file) close(file);
    return instance;
}

FMI2_EXPORT void fmi2FreeInstance(fmi2Component c) {
    if (is("segfault_on_free")) crash();
    if (is("hang_on_free")) hang();
    --instances_alive;
    free(c);
}

FMI2_EXPORT fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean with_tolerance, fmi2Real tolerance,
                                           fmi2Real begin, fmi2Boolean with_stop, fmi2Real stop) {
    (void)with_tolerance, (void)tolerance;
    Instance *instance = c;
    if (is("segfault_on_setup")) crash();
    instance->time = begin;
    if (with_stop) instance->stop = stop;
    return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    (void)c;
    if (is("segfault_on_initialise")) crash();
    if (is("hang_on_initialise")) hang();
    return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    (void)c;
    return fmi2OK;
}

/* ---- values ---------------------------------------------------------------------------- */

#define SET_AND_GET(NAME, C_TYPE)                                                                    \
    FMI2_EXPORT fmi2Status fmi2Set##NAME(fmi2Component c, const fmi2ValueReference vr[], size_t n,    \
                                         const C_TYPE value[]) {                                    \
        if (is("segfault_on_set")) crash();                                                         \
        for (size_t i = 0; i < n; ++i) ((Instance *)c)->value[vr[i]] = value[i];                    \
        return fmi2OK;                                                                              \
    }                                                                                               \
    FMI2_EXPORT fmi2Status fmi2Get##NAME(fmi2Component c, const fmi2ValueReference vr[], size_t n,    \
                                         C_TYPE value[]) {                                          \
        if (is("segfault_on_get")) crash();                                                         \
        if (is("leaves_outputs_unwritten")) return fmi2OK;                                          \
        for (size_t i = 0; i < n; ++i) value[i] = (C_TYPE)((Instance *)c)->value[vr[i]];            \
        return fmi2OK;                                                                              \
    }

SET_AND_GET(Real, fmi2Real)

/* ---- steps ----------------------------------------------------------------------------- */

static void scribble(void) {
    for (int file = 3; file < 64; ++file) {
        int mode = fcntl(file, F_GETFL);
        if (mode >= 0 && (mode & O_ACCMODE) == O_WRONLY && write(file, "{}\n", 3) != 3) continue;
    }
}

static fmi2Status fail(Instance *instance) {
    double *position = &instance->value[V_position];
    if (is("segfault_in_step")) crash();
    if (is("abort_in_step")) abort();
    if (is("exit_in_step")) exit(0);
    if (is("hang_in_step")) hang();
    if (is("nan")) *position = NAN;
    if (is("huge")) *position = 1e300;
    if (is("output_lies")) *position *= 1.1;
    if (is("leak_without_end")) leak((size_t)64 << 20);
    if (is("writes_into_answers")) scribble();
    if (is("discard") || is("discard_without_termination"))
        return report(instance, fmi2Discard, "the step was too long");
    if (is("warning_each_step")) return report(instance, fmi2Warning, "the table was left at its edge");
    if (is("error_at")) return report(instance, fmi2Error, "the solver did not converge");
    if (is("fatal_at")) return report(instance, fmi2Fatal, "no instance can go on");
    return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_set_state) {
    (void)no_set_state;
    Instance *instance = c;
    if (is("fixed_step") && fabs(h - INTERNAL_STEP) > 1e-9)
        return report(instance, fmi2Error, "the step is fixed");
    if (is("stop_time_enforced") && t + h > instance->stop)
        return report(instance, fmi2Error, "the step goes beyond the stop time");
    instance->value[V_position] = instance->value[V_gain] * instance->value[V_reference];
    if (is("reset_does_not_reset")) instance->value[V_position] += 1e-3 * instance->state++;
    if (is("prints")) {
        puts("fault prints to standard output");
        fflush(stdout);
    }
    fmi2Status status = t >= instance->value[V_at] - 1e-6 * h ? fail(instance) : fmi2OK;
    if (is("hostile") && instance->value[V_outcome] == 0.0)
        instance->value[V_outcome] = attempt((int)instance->value[V_attempt]);
    if (status <= fmi2Warning) instance->time = t + h;
    return status;
}

#ifndef REQUIRED_ONLY
SET_AND_GET(Integer, fmi2Integer)
SET_AND_GET(Boolean, fmi2Boolean)

FMI2_EXPORT fmi2Status fmi2Reset(fmi2Component c) {
    if (is("reset_does_not_reset")) return fmi2OK;
    start(c);
    return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2Terminate(fmi2Component c) {
    (void)c;
    return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2GetBooleanStatus(fmi2Component c, fmi2StatusKind kind, fmi2Boolean *value) {
    (void)c;
    if (kind != fmi2Terminated) return fmi2Discard;
    *value = is("discard");
    return fmi2OK;
}

FMI2_EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
FMI2_EXPORT const char *fmi2GetVersion(void) { return "2.0"; }
#endif
