/* Runs FMI 2.0 co-simulation FMUs, wired in a stated order, over arrays. */
#ifndef GMFBO_MASTER_H
#define GMFBO_MASTER_H

#include <stdint.h>

/* An instance in step mode and the addresses of its FMI functions. */
typedef struct {
    void *component;
    void *set_real, *get_real, *set_integer, *get_integer, *set_boolean, *get_boolean, *do_step;
} gm_fmu;

enum { GM_REAL, GM_INTEGER, GM_BOOLEAN };

/* A variable and the column of the array that it is read from or written to. */
typedef struct {
    int32_t fmu;
    uint32_t vr;
    int32_t type;
    int32_t column;
} gm_port;

/* input = scale * output; before every step of the FMU that owns the input. */
typedef struct {
    int32_t to_fmu;
    uint32_t to_vr;
    int32_t to_type;
    int32_t from_fmu;
    uint32_t from_vr;
    int32_t from_type;
    double scale;
} gm_wire;

enum { GM_OK, GM_STOPPED, GM_NO_MEMORY, GM_BAD_ARGUMENT };
enum { GM_STAGE_NONE, GM_STAGE_SET, GM_STAGE_STEP, GM_STAGE_GET, GM_STAGE_NOT_FINITE };

/* How a run ended. With GM_STOPPED, `fmu` and `stage` say where, `step` the index of the step under
 * way (-1 while row 0 is read), `fmi_status` the answer. Rows 0 to `step` of y are then valid; at
 * GM_STAGE_NOT_FINITE row `step + 1` is filled too and holds the value that is not finite. */
typedef struct {
    int32_t status, fmu, stage;
    int64_t step;
    int32_t fmi_status;
    int32_t warnings; /* calls that answered fmi2Warning */
} gm_result;

#if defined(_WIN32)
#define GM_EXPORT __declspec(dllexport)
#else
#define GM_EXPORT __attribute__((visibility("default")))
#endif

/* Simulate n_steps steps of h [s] from t0 [s].
 *
 * u [n_steps][n_u] are external inputs, set before each step; s [n_steps][n_s] are parameters,
 * set only where the value differs from the row before. Row 0 of y [n_steps+1][n_y] is read before
 * the first step, row k at t0 + k h. Within a step the FMUs go in their order: inputs, wires with
 * the newest outputs, then the step itself. An input that is named more than once gets the sum. Any
 * answer above fmi2Warning stops the run, and so does a Real that is NaN or infinite. Returns result->status. Thread safe; owns nothing. */
GM_EXPORT int gm_run(int32_t n_fmus, const gm_fmu *fmus, int64_t n_steps, double t0, double h,
                     int32_t n_in, const gm_port *in, const double *u, int32_t n_u,
                     int32_t n_sched, const gm_port *sched, const double *s, int32_t n_s,
                     int32_t n_wires, const gm_wire *wires,
                     int32_t n_out, const gm_port *out, double *y, int32_t n_y, gm_result *result);

#endif
