/* The floor of the stepping benchmark: the same FMI calls as gmfbo's driver, from a plain C program.
   usage: stepping LIBRARY GUID RESOURCES STEPS H RUNS IN_VR OUT_VR...
   Prints the seconds of the fastest run, instantiation and release included. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

typedef void *Component;
typedef unsigned Ref;
typedef struct {
    void (*log)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void *finished, *environment;
} Callbacks;

static void say_nothing(void *e, const char *i, int s, const char *c, const char *m, ...) {
    (void)e, (void)i, (void)s, (void)c, (void)m;
}

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

int main(int argc, char **argv) {
    if (argc < 9) return 2;
    void *library = dlopen(argv[1], RTLD_NOW);
    if (!library) { fprintf(stderr, "%s\n", dlerror()); return 3; }
    Component (*instantiate)(const char *, int, const char *, const char *, const Callbacks *, int, int) = dlsym(library, "fmi2Instantiate");
    int (*setup)(Component, int, double, double, int, double) = dlsym(library, "fmi2SetupExperiment");
    int (*enter)(Component) = dlsym(library, "fmi2EnterInitializationMode");
    int (*leave)(Component) = dlsym(library, "fmi2ExitInitializationMode");
    int (*set_real)(Component, const Ref *, size_t, const double *) = dlsym(library, "fmi2SetReal");
    int (*get_real)(Component, const Ref *, size_t, double *) = dlsym(library, "fmi2GetReal");
    int (*do_step)(Component, double, double, int) = dlsym(library, "fmi2DoStep");
    int (*terminate)(Component) = dlsym(library, "fmi2Terminate");
    void (*release)(Component) = dlsym(library, "fmi2FreeInstance");
    const Callbacks callbacks = {say_nothing, calloc, free, NULL, NULL};
    const long steps = atol(argv[4]), runs = atol(argv[6]);
    const double h = atof(argv[5]);
    const Ref in = (Ref)atol(argv[7]);
    const int n_out = argc - 8;
    Ref out[64];
    for (int i = 0; i < n_out; i++) out[i] = (Ref)atol(argv[8 + i]);
    double *y = malloc(sizeof(double) * (size_t)n_out * (size_t)(steps + 1));
    double *u = malloc(sizeof(double) * (size_t)steps);
    for (long k = 0; k < steps; k++) u[k] = k * h >= 0.1 ? 1.0 : 0.0;
    double best = 1e9;
    for (long run = 0; run < runs; run++) {
        const double start = now();
        Component c = instantiate("floor", 1, argv[2], argv[3], &callbacks, 0, 0);
        if (!c || setup(c, 0, 0.0, 0.0, 0, 0.0) > 1 || enter(c) > 1 || leave(c) > 1) return 3;
        get_real(c, out, (size_t)n_out, y);
        for (long k = 0; k < steps; k++) {
            if (set_real(c, &in, 1, &u[k]) > 1 || do_step(c, k * h, h, 1) > 1) return 3;
            if (get_real(c, out, (size_t)n_out, y + (size_t)n_out * (size_t)(k + 1)) > 1) return 3;
        }
        terminate(c);
        release(c);
        const double spent = now() - start;
        if (spent < best) best = spent;
    }
    printf("%.9f %.17g\n", best, y[(size_t)n_out * (size_t)steps]);
    return 0;
}
