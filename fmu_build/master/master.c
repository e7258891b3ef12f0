#include "master.h"

#include <math.h>
#include <stdlib.h>

#include "calls.h"

/* Every port and wire end resolved to its place in a group, so that a step only copies. */
typedef struct {
    Group *set, *get; /* [n_fmus][GM_TYPES] */
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
    Group *group = &groups[fmu * GM_TYPES + type];
    size_t i = 0;
    while (i < group->n && group->vr[i] != vr) ++i;
    if (i == group->n) group->vr[group->n++] = vr;
    return &group->value[i];
}

static int32_t types_of(const gm_fmu *fmu) { return fmu->fmi == 3 ? GM_TYPES : GM_BOOLEAN + 1; }

static int valid_port(const Run *run, const gm_port *port, int32_t columns) {
    return port->fmu >= 0 && port->fmu < run->n_fmus && port->type >= GM_REAL &&
           port->type < types_of(&run->fmus[port->fmu]) && port->column >= 0 && port->column < columns;
}

static int valid_ports(const Run *run, int32_t n, const gm_port *ports, int32_t columns) {
    for (int32_t i = 0; i < n; ++i)
        if (!valid_port(run, &ports[i], columns)) return 0;
    return 1;
}

static int valid_wires(const Run *run) {
    for (int32_t i = 0; i < run->n_wires; ++i) {
        const gm_wire *wire = &run->wires[i];
        gm_port to = {wire->to_fmu, wire->to_vr, wire->to_type, 0};
        gm_port from = {wire->from_fmu, wire->from_vr, wire->from_type, 0};
        if (!valid_port(run, &to, 1) || !valid_port(run, &from, 1)) return 0;
    }
    return 1;
}

static int valid_fmus(const Run *run) {
    for (int32_t i = 0; i < run->n_fmus; ++i)
        if ((run->fmus[i].fmi != 2 && run->fmus[i].fmi != 3) || !run->fmus[i].do_step) return 0;
    return run->n_fmus > 0;
}

static int valid(const Run *run, int64_t n_steps) {
    return valid_fmus(run) && n_steps >= 0 && run->h > 0.0 && valid_ports(run, run->n_in, run->in, run->n_u) &&
           valid_ports(run, run->n_sched, run->sched, run->n_s) &&
           valid_ports(run, run->n_out, run->out, run->n_y) && valid_wires(run);
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
        groups[i].raw = take(cursor, room * sizeof(int64_t)); /* the widest type */
        groups[i].value = take(cursor, room * sizeof(double));
    }
    return groups;
}

static int make_plan(Run *run) {
    Plan *plan = &run->plan;
    size_t n_in = (size_t)run->n_in, n_wires = (size_t)run->n_wires, n_out = (size_t)run->n_out;
    size_t n_groups = (size_t)run->n_fmus * GM_TYPES;
    size_t room = n_in + n_wires + n_out; /* no group can need more */
    size_t group_bytes = sizeof(Group) + room * (sizeof(uint32_t) + sizeof(int64_t) + sizeof(double)) + 24;
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
    const gm_fmu *f = &run->fmus[fmu];
    if (group->n == 0) return 1;
    int status = FMI_ERROR; /* of a function that the library lacks */
    if (f->set[type]) status = f->fmi == 3 ? fmi3_set(f, type, group) : fmi2_set(f, type, group);
    return goes_on(run, fmu, GM_STAGE_SET, status);
}

static int get_group(Run *run, int32_t fmu, int32_t type, Group *group) {
    const gm_fmu *f = &run->fmus[fmu];
    if (group->n == 0) return 1;
    int status = FMI_ERROR;
    if (f->get[type]) status = f->fmi == 3 ? fmi3_get(f, type, group) : fmi2_get(f, type, group);
    return goes_on(run, fmu, GM_STAGE_GET, status);
}

static int get_all(Run *run, int32_t fmu) {
    for (int32_t type = 0; type < types_of(&run->fmus[fmu]); ++type)
        if (!get_group(run, fmu, type, &run->plan.get[fmu * GM_TYPES + type])) return 0;
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
        int64_t raw;
        Group one = {1, &vr, &value, &raw};
        if (!set_group(run, fmu, port->type, &one)) return 0;
    }
    return 1;
}

static int set_inputs(Run *run, int32_t fmu) {
    Plan *plan = &run->plan;
    Group *set = &plan->set[fmu * GM_TYPES];
    int32_t types = types_of(&run->fmus[fmu]);
    const double *row = run->u + run->step * run->n_u;
    for (int32_t type = 0; type < types; ++type)
        for (size_t i = 0; i < set[type].n; ++i) set[type].value[i] = 0.0;
    for (int32_t i = 0; i < run->n_in; ++i)
        if (run->in[i].fmu == fmu) *plan->in[i] += row[run->in[i].column];
    for (int32_t i = 0; i < run->n_wires; ++i)
        if (run->wires[i].to_fmu == fmu) *plan->wire_to[i] += run->wires[i].scale * *plan->wire_from[i];
    for (int32_t type = 0; type < types; ++type)
        if (!set_group(run, fmu, type, &set[type])) return 0;
    return 1;
}

static int do_step(Run *run, int32_t fmu) {
    const gm_fmu *f = &run->fmus[fmu];
    double t = run->t0 + (double)run->step * run->h; /* never a running sum */
    int32_t stage = GM_STAGE_STEP;
    int status = f->fmi == 3 ? fmi3_step(f, t, run->h, &stage) : fmi2_step(f, t, run->h);
    return goes_on(run, fmu, stage, status);
}

/* ---- the run --------------------------------------------------------------------------- */

static int all_finite(const Group *group) {
    for (size_t i = 0; i < group->n; ++i)
        if (!isfinite(group->value[i])) return 0;
    return 1;
}

/* First FMU of which a real number that was read is NaN or infinite, or -1. */
static int32_t first_not_finite(const Run *run) {
    for (int32_t fmu = 0; fmu < run->n_fmus; ++fmu) {
        const Group *get = &run->plan.get[fmu * GM_TYPES];
        if (!all_finite(&get[GM_REAL]) || !all_finite(&get[GM_FLOAT32])) return fmu;
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
    Run run = {
        .fmus = fmus, .n_fmus = n_fmus, .t0 = t0, .h = h, .result = result,
        .in = in, .n_in = n_in, .u = u, .n_u = n_u,
        .sched = sched, .n_sched = n_sched, .s = s, .n_s = n_s,
        .wires = wires, .n_wires = n_wires,
        .out = out, .n_out = n_out, .y = y, .n_y = n_y,
    };
    if (!valid(&run, n_steps)) return result->status = GM_BAD_ARGUMENT;
    if (!make_plan(&run)) return result->status = GM_NO_MEMORY;
    run.step = -1;
    while (advance(&run) && run.step + 1 < n_steps) ++run.step;
    free(run.plan.memory);
    return result->status;
}
