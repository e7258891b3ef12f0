/* A small FMU of FMI 2.0, or 3.0 with -DFMI3, with one habit of vendors' FMUs for each macro. */
#include <stddef.h>
#include <string.h>

enum { OK = 0, ERROR = 3 };
enum { REFERENCE = 0, POSITION = 1, GAIN = 2, LENGTH = 3 };

typedef struct {
    void *environment;
    void (*log)(void *, const char *, int, const char *, const char *, ...);
    double real[4];
    int integer[2];
    int boolean[2];
    char text[512];
} Model;

static Model model;

#ifdef BESIDE
double gain_of_the_library_beside(void);
#endif

#ifdef ARRAYS
static double array[3][4];
#endif

static void reset(void)
{
#ifdef ARRAYS
    static const double start[3][4] = {{0, 0, 0, 0}, {0, 0, 0, 0}, {1, 2, 3, 4}};
    memcpy(array, start, sizeof start);
#endif
    memset(&model, 0, sizeof model);
    model.real[GAIN] = 1.0;
    model.boolean[0] = 1;
    strcpy(model.text, "short");
}

static void compute(void)
{
    double gain = model.real[GAIN];
#ifdef BESIDE
    gain = gain_of_the_library_beside();
#endif
    model.real[POSITION] = model.boolean[0] ? gain * model.real[REFERENCE] : 0.0;
    model.real[LENGTH] = (double)strlen(model.text) + 100.0 * model.integer[0];
}

static int step(void)
{
#ifdef HANG
    volatile int forever = 1;
    while (forever) {
    }
#endif
    compute();
    return OK;
}

#define COPY(call, type, values, to, from)                                                    \
    int call(void *m, const unsigned r[], size_t n, type values[])                              \
    {                                                                                           \
        for (size_t k = 0; k < n; k++)                                                          \
            to = from;                                                                          \
        return OK;                                                                              \
    }

#ifndef FMI3
typedef struct {
    void (*log)(void *, const char *, int, const char *, const char *, ...);
    void *allocate, *release, *finished;
    void *environment;
} Callbacks;

void *fmi2Instantiate(const char *name, int kind, const char *guid, const char *resources,
                      const Callbacks *callbacks, int visible, int logging)
{
    reset();
    model.log = callbacks->log;
    model.environment = callbacks->environment;
    return &model;
}
void fmi2FreeInstance(void *m) {}
int fmi2SetupExperiment(void *m, int tolerant, double tolerance, double start, int stops, double stop)
{
#ifdef NEEDS_STOP
    if (!stops) {
        model.log(model.environment, "small", ERROR, "", "no End Time was given");
        return ERROR;
    }
    model.real[GAIN] = stop;
#endif
    return OK;
}
int fmi2EnterInitializationMode(void *m) { return OK; }
int fmi2ExitInitializationMode(void *m)
{
#ifdef LICENCE
    model.log(model.environment, "small", ERROR, "", "%s", LICENCE);
    return ERROR;
#endif
    compute();
    return OK;
}
COPY(fmi2SetReal, const double, x, model.real[r[k]], x[k])
COPY(fmi2GetReal, double, x, x[k], model.real[r[k]])
COPY(fmi2SetInteger, const int, x, model.integer[r[k]], x[k])
COPY(fmi2GetInteger, int, x, x[k], model.integer[r[k]])
COPY(fmi2SetBoolean, const int, x, model.boolean[r[k]], x[k])
COPY(fmi2GetBoolean, int, x, x[k], model.boolean[r[k]])
int fmi2SetString(void *m, const unsigned r[], size_t n, const char *const x[])
{
    strncpy(model.text, x[0], sizeof model.text - 1);
    return OK;
}
int fmi2DoStep(void *m, double time, double length, int no_set) { return step(); }
#else
void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources,
                                  _Bool visible, _Bool logging, _Bool events, _Bool early,
                                  const unsigned r[], size_t n, void *environment, void *log,
                                  void *update)
{
    reset();
    return &model;
}
void fmi3FreeInstance(void *m) {}
int fmi3EnterInitializationMode(void *m, _Bool tolerant, double tolerance, double start, _Bool stops,
                                double stop)
{
    return OK;
}
int fmi3ExitInitializationMode(void *m)
{
    compute();
    return OK;
}
COPY(fmi3SetInt64, const long long, x, model.integer[r[k]], (int)x[k])
COPY(fmi3SetBoolean, const _Bool, x, model.boolean[r[k]], x[k])
#ifdef ARRAYS
/* value references 10: reference[2,2], 11: position[2,2] = gain * reference, 12: gain[2,2] */
int fmi3SetFloat64(void *m, const unsigned r[], size_t n, const double x[], size_t count)
{
    if (n != 1 || count != 4 || r[0] < 10 || r[0] > 12)
        return ERROR;
    memcpy(array[r[0] - 10], x, sizeof array[0]);
    return OK;
}
int fmi3GetFloat64(void *m, const unsigned r[], size_t n, double x[], size_t count)
{
    if (n != 1 || count != 4 || r[0] < 10 || r[0] > 12)
        return ERROR;
    for (int k = 0; k < 4; k++)
        array[1][k] = array[2][k] * array[0][k];
    memcpy(x, array[r[0] - 10], sizeof array[0]);
    return OK;
}
#else
COPY(fmi3SetFloat64, const double, x, model.real[r[k]], x[k])
COPY(fmi3GetFloat64, double, x, x[k], model.real[r[k]])
#endif
int fmi3SetString(void *m, const unsigned r[], size_t n, const char *const x[], size_t count)
{
    strncpy(model.text, x[0], sizeof model.text - 1);
    return count == 1 ? OK : ERROR;
}
int fmi3DoStep(void *m, double time, double length, _Bool no_set, _Bool *event, _Bool *end,
               _Bool *early, double *last)
{
    *event = *end = *early = 0;
    *last = time + length;
    return step();
}
#endif
