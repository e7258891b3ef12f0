/* What a model gives to the FMI wrapper, and the table of variables that is generated for it.
 *
 * A model is one C file that defines `struct Model`, whose first member is
 * `double v[N_VARIABLES]` and whose other members are plain data without pointers: a state is
 * copied, stored and restored byte by byte.
 *
 * Every function returns NULL, or one line that says what went wrong. A line that begins with
 * "warning:" or "discard:" becomes fmi2Warning or fmi2Discard, any other fmi2Error. */
#ifndef GMFBO_MODEL_H
#define GMFBO_MODEL_H

#include <stddef.h>

#include "variables.h"

typedef struct Model Model;

extern const size_t model_bytes;

/* Parameters and inputs are in v[]; all behind v[] is zero. Compute states and outputs at the
 * start time. `resources` is the folder of the unpacked resources, without a final slash. */
const char *model_initialise(Model *m, const char *resources);

/* Advance from t to t + h [s] with inputs held, and refresh the outputs in v[]. */
const char *model_step(Model *m, double t, double h);

/* The tunable parameter v[index] was set between two steps. */
const char *model_parameter_changed(Model *m, int index);

typedef enum { CAUSALITY_PARAMETER, CAUSALITY_INPUT, CAUSALITY_OUTPUT, CAUSALITY_LOCAL } Causality;
typedef enum { TYPE_REAL, TYPE_INTEGER, TYPE_BOOLEAN } VariableType;

typedef struct {
    const char *name;
    const char *unit;
    double start, min, max;
    Causality causality;
    VariableType type;
    int tunable;
} Variable;

/* Generated from model.toml; the value reference of a variable is its index. */
extern const Variable model_variables[N_VARIABLES];
extern const char model_name[];
extern const char model_guid[];

#endif
