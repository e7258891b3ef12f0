#include "master.h"

#include <math.h>
#include <stdlib.h>

typedef int (*RealSetter)(void *, const uint32_t *, size_t, const double *);
typedef int (*RealGetter)(void *, const uint32_t *, size_t, double *);
typedef int (*WholeSetter)(void *, const uint32_t *, size_t, const int32_t *);
typedef int (*WholeGetter)(void *, const uint32_t *, size_t, int32_t *);
typedef int (*Stepper)(void *, double t, double h, int no_set_state);

enum { FMI_OK, FMI_WARNING, FMI_DISCARD };
enum { TYPES = 3 };

/* Variables of one FMU and one type that are set, or read, by one call. */
typedef struct {
    size_t n;
    uint32_t *vr;
    double *value;
    int32_t *whole; /* the same values as integers, which Integer and Boolean calls take */
} Group;

/* Every port and wire end resolved to its place in a group, so that a step only copies. */
typedef struct {
    Group *set, *get; /* [n_fmus][TYPES] */
    double **in, **wire_to, **wire_from, **out;
    void *memory;
} Plan;

typedef struct {
    const gm_fmu *fmus;
    int32_t n_fmus, n_in, n_u, n_sched, n_s, n_wires, n_out, n_y;
    const gm_port *in, *sched, *out;
    const gm_wire *wires;
    const double *u, *s;
    double *y;
    double t0, h;
    Plan plan;
    int64_t step; /* index of the step under way; -1 while row 0 is read */
    gm_result *result;
} Run;

/* ---- planning -------------------------------------------------------------------------- */

/* Place of a variable in its group; a variable that is named twice has one place. */
static double *place(Group *groups, int32_t fmu, uint32_t vr, int32_t type) {
    Group *group = &groups[fmu * TYPES + type];
    size_t i = 0;
    while (i < group->n && group->vr[i] != vr) ++i;
    if (i == group->n) group->vr[group->n++] = vr;
    return &group->value[i];
}

static int valid_port(const gm_port *port, int32_t n_fmus, int32_t columns) {
    return port->fmu >= 0 && port->fmu < n_fmus && port->type >= GM_REAL && port->type <= GM_BOOLEAN &&
           port->column >= 0 && port->column < columns;
}

static int valid_ports(int32_t n, const gm_port *ports, int32_t n_fmus, int32_t columns) {
    for (int32_t i = 0; i < n; ++i)
        if (!valid_port(&ports[i], n_fmus, columns)) return 0;
    return 1;
}

static int valid_wires(int32_t n, const gm_wire *wires, int32_t n_fmus) {
    for (int32_t i = 0; i < n; ++i) {
        gm_port to = {wires[i].to_fmu, wires[i].to_vr, wires[i].to_type, 0};
        gm_port from = {wires[i].from_fmu, wires[i].from_vr, wires[i].from_type, 0};
        if (!valid_port(&to, n_fmus, 1) || !valid_port(&from, n_fmus, 1)) return 0;
    }
    return 1;
}

/* Takes `bytes` from the block at *cursor, which stays aligned for doubles and pointers. */
static void *take(char **cursor, size_t bytes) {
    char *taken = *cursor;
    *cursor += (bytes + 7) / 8 * 8;
    return taken;
}

static Group *take_groups(char **cursor, size_t n_groups, size_t room) {
    Group *groups = take(cursor, n_groups * sizeof(Group));
    for (size_t i = 0; i < n_groups; ++i) {
        groups[i].vr = take(cursor, room * sizeof(uint32_t));
        groups[i].whole = take(cursor, room * sizeof(int32_t));
        groups[i].value = take(cursor, room * sizeof(double));
    }
    return groups;
}

static int make_plan(Run *run) {
    Plan *plan = &run->plan;
    size_t n_in = (size_t)run->n_in, n_wires = (size_t)run->n_wires, n_out = (size_t)run->n_out;
    size_t n_groups = (size_t)run->n_fmus * TYPES;
    size_t room = n_in + n_wires + n_out; /* no group can need more */
    size_t group_bytes = sizeof(Group) + room * (sizeof(uint32_t) + sizeof(int32_t) + sizeof(double)) + 24;
    plan->memory = calloc(1, 2 * n_groups * group_bytes + (n_in + 2 * n_wires + n_out) * sizeof(double *) + 64);
    if (!plan->memory) return 0;
    char *cursor = plan->memory;
    plan->set = take_groups(&cursor, n_groups, room);
    plan->get = take_groups(&cursor, n_groups, room);
    plan->in = take(&cursor, n_in * sizeof(double *));
    plan->wire_to = take(&cursor, n_wires * sizeof(double *));
    plan->wire_from = take(&cursor, n_wires * sizeof(double *));
    plan->out = take(&cursor, n_out * sizeof(double *));
    for (size_t i = 0; i < n_in; ++i)
        plan->in[i] = place(plan->set, run->in[i].fmu, run->in[i].vr, run->in[i].type);
    for (size_t i = 0; i < n_wires; ++i) {
        const gm_wire *wire = &run->wires[i];
        plan->wire_to[i] = place(plan->set, wire->to_fmu, wire->to_vr, wire->to_type);
        plan->wire_from[i] = place(plan->get, wire->from_fmu, wire->from_vr, wire->from_type);
    }
    for (size_t i = 0; i < n_out; ++i)
        plan->out[i] = place(plan->get, run->out[i].fmu, run->out[i].vr, run->out[i].type);
    return 1;
}

/* ---- calls of one FMU ------------------------------------------------------------------ */

/* Counts a warning; fills the result and answers 0 where the run has to stop. */
static int goes_on(Run *run, int32_t fmu, int32_t stage, int fmi_status) {
    if (fmi_status == FMI_OK) return 1;
    if (fmi_status == FMI_WARNING) {
        ++run->result->warnings;
        return 1;
    }
    gm_result *result = run->result;
    result->status = GM_STOPPED;
    result->fmu = fmu;
    result->stage = stage;
    result->step = run->step;
    result->fmi_status = fmi_status;
    return 0;
}

static int set_group(Run *run, int32_t fmu, int32_t type, Group *group) {
    if (group->n == 0) return 1;
    const gm_fmu *f = &run->fmus[fmu];
    int status;
    if (type == GM_REAL) {
        status = ((RealSetter)f->set_real)(f->component, group->vr, group->n, group->value);
    } else {
        for (size_t i = 0; i < group->n; ++i)
            group->whole[i] = type == GM_BOOLEAN ? group->value[i] != 0.0 : (int32_t)lround(group->value[i]);
        WholeSetter set = (WholeSetter)(type == GM_INTEGER ? f->set_integer : f->set_boolean);
        status = set(f->component, group->vr, group->n, group->whole);
    }
    return goes_on(run, fmu, GM_STAGE_SET, status);
}

static int get_group(Run *run, int32_t fmu, int32_t type, Group *group) {
    if (group->n == 0) return 1;
    const gm_fmu *f = &run->fmus[fmu];
    int status;
    if (type == GM_REAL) {
        status = ((RealGetter)f->get_real)(f->component, group->vr, group->n, group->value);
    } else {
        WholeGetter get = (WholeGetter)(type == GM_INTEGER ? f->get_integer : f->get_boolean);
        status = get(f->component, group->vr, group->n, group->whole);
        for (size_t i = 0; i < group->n; ++i) group->value[i] = group->whole[i];
    }
    return goes_on(run, fmu, GM_STAGE_GET, status);
}

static int get_all(Run *run, int32_t fmu) {
    for (int32_t type = 0; type < TYPES; ++type)
        if (!get_group(run, fmu, type, &run->plan.get[fmu * TYPES + type])) return 0;
    return 1;
}

/* Scheduled parameters, where their value differs from the row before. */
static int set_schedule(Run *run, int32_t fmu) {
    for (int32_t i = 0; i < run->n_sched; ++i) {
        const gm_port *port = &run->sched[i];
        if (port->fmu != fmu) continue;
        const double *cell = run->s + run->step * run->n_s + port->column;
        if (run->step > 0 && cell[0] == cell[-run->n_s]) continue;
        uint32_t vr = port->vr;
        double value = *cell;
        int32_t whole;
        Group one = {1, &vr, &value, &whole};
        if (!set_group(run, fmu, port->type, &one)) return 0;
    }
    return 1;
}

static int set_inputs(Run *run, int32_t fmu) {
    Plan *plan = &run->plan;
    Group *set = &plan->set[fmu * TYPES];
    const double *row = run->u + run->step * run->n_u;
    for (int32_t type = 0; type < TYPES; ++type)
        for (size_t i = 0; i < set[type].n; ++i) set[type].value[i] = 0.0;
    for (int32_t i = 0; i < run->n_in; ++i)
        if (run->in[i].fmu == fmu) *plan->in[i] += row[run->in[i].column];
    for (int32_t i = 0; i < run->n_wires; ++i)
        if (run->wires[i].to_fmu == fmu) *plan->wire_to[i] += run->wires[i].scale * *plan->wire_from[i];
    for (int32_t type = 0; type < TYPES; ++type)
        if (!set_group(run, fmu, type, &set[type])) return 0;
    return 1;
}

static int do_step(Run *run, int32_t fmu) {
    const gm_fmu *f = &run->fmus[fmu];
    double t = run->t0 + (double)run->step * run->h; /* never a running sum */
    return goes_on(run, fmu, GM_STAGE_STEP, ((Stepper)f->do_step)(f->component, t, run->h, 1));
}

/* ---- the run --------------------------------------------------------------------------- */

/* First FMU of which a Real that was read is NaN or infinite, or -1. */
static int32_t first_not_finite(const Run *run) {
    for (int32_t fmu = 0; fmu < run->n_fmus; ++fmu) {
        const Group *reals = &run->plan.get[fmu * TYPES + GM_REAL];
        for (size_t i = 0; i < reals->n; ++i)
            if (!isfinite(reals->value[i])) return fmu;
    }
    return -1;
}

/* One communication step of all FMUs and the row of y after it; step -1 only reads. */
static int advance(Run *run) {
    for (int32_t fmu = 0; fmu < run->n_fmus; ++fmu) {
        if (run->step >= 0 && !(set_schedule(run, fmu) && set_inputs(run, fmu) && do_step(run, fmu))) return 0;
        if (!get_all(run, fmu)) return 0;
    }
    double *row = run->y + (run->step + 1) * run->n_y;
    for (int32_t i = 0; i < run->n_out; ++i) row[run->out[i].column] = *run->plan.out[i];
    int32_t fmu = first_not_finite(run);
    if (fmu < 0) return 1;
    *run->result = (gm_result){GM_STOPPED, fmu, GM_STAGE_NOT_FINITE, run->step, FMI_OK, run->result->warnings};
    return 0;
}

int gm_run(int32_t n_fmus, const gm_fmu *fmus, int64_t n_steps, double t0, double h, int32_t n_in,
           const gm_port *in, const double *u, int32_t n_u, int32_t n_sched, const gm_port *sched,
           const double *s, int32_t n_s, int32_t n_wires, const gm_wire *wires, int32_t n_out,
           const gm_port *out, double *y, int32_t n_y, gm_result *result) {
    *result = (gm_result){0};
    if (n_fmus < 1 || n_steps < 0 || !(h > 0.0) || !valid_ports(n_in, in, n_fmus, n_u) ||
        !valid_ports(n_sched, sched, n_fmus, n_s) || !valid_ports(n_out, out, n_fmus, n_y) ||
        !valid_wires(n_wires, wires, n_fmus))
        return result->status = GM_BAD_ARGUMENT;
    Run run = {
        .fmus = fmus, .n_fmus = n_fmus, .t0 = t0, .h = h, .result = result,
        .in = in, .n_in = n_in, .u = u, .n_u = n_u,
        .sched = sched, .n_sched = n_sched, .s = s, .n_s = n_s,
        .wires = wires, .n_wires = n_wires,
        .out = out, .n_out = n_out, .y = y, .n_y = n_y,
    };
    if (!make_plan(&run)) return result->status = GM_NO_MEMORY;
    run.step = -1;
    while (advance(&run) && run.step + 1 < n_steps) ++run.step;
    free(run.plan.memory);
    return result->status;
}
