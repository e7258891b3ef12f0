/* Runs co-simulation FMUs of FMI 2.0 and 3.0, wired in a stated order, over arrays. */
#ifndef GMFBO_MASTER_H
#define GMFBO_MASTER_H

#include <stdint.h>

/* Types of values; FMI 2.0 has the first three. In FMI 3.0 GM_REAL is Float64, GM_INTEGER Int32, and
 * an enumeration GM_INT64. */
enum {
    GM_REAL, GM_INTEGER, GM_BOOLEAN,
    GM_FLOAT32, GM_INT8, GM_UINT8, GM_INT16, GM_UINT16, GM_UINT32, GM_INT64, GM_UINT64,
    GM_TYPES
};

/* An instance in step mode and the addresses of its FMI functions, by type of value; NULL for one that
 * its library lacks. */
typedef struct {
    void *component;
    void *do_step;
    void *set[GM_TYPES], *get[GM_TYPES];
    int32_t fmi; /* 2 or 3 */
} gm_fmu;

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
enum {
    GM_STAGE_NONE, GM_STAGE_SET, GM_STAGE_STEP, GM_STAGE_GET, GM_STAGE_NOT_FINITE,
    GM_STAGE_EVENT, /* FMI 3.0: the step asks for event mode, or returned early */
    GM_STAGE_ENDED  /* FMI 3.0: the step asks for the end of the simulation */
};

/* How a run ended. With GM_STOPPED, `fmu` and `stage` say where, `step` the index of the step under
 * way (-1 while row 0 is read), `fmi_status` the answer. Rows 0 to `step` of y are then valid; at
 * GM_STAGE_NOT_FINITE row `step + 1` is filled too and holds the value that is not finite. */
typedef struct {
    int32_t status, fmu, stage;
    int64_t step;
    int32_t fmi_status;
    int32_t warnings; /* calls that answered with a warning */
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
 * answer above a warning stops the run, and so does a Real that is NaN or infinite. Returns
 * result->status. Thread safe; owns nothing. */
GM_EXPORT int gm_run(int32_t n_fmus, const gm_fmu *fmus, int64_t n_steps, double t0, double h,
                     int32_t n_in, const gm_port *in, const double *u, int32_t n_u,
                     int32_t n_sched, const gm_port *sched, const double *s, int32_t n_s,
                     int32_t n_wires, const gm_wire *wires,
                     int32_t n_out, const gm_port *out, double *y, int32_t n_y, gm_result *result);

#endif
