/* Free play: a load between two elastic flanks on the twin's shaft. */
#ifndef GMFBO_PHYSICS_BACKLASH_H
#define GMFBO_PHYSICS_BACKLASH_H

#include "joint.h"
#include "load.h"

#define BACKLASH_STEP 20e-6    /* [s] touch and release are looked for this often */
#define BACKLASH_BISECTIONS 12 /* and found to a part of it: 5 ns */

/* By the inertia that they move. */
typedef struct {
    double half_gap, stiffness, damping;
} Flanks;

/* The flank that presses, -1 or 1, or 0: a flank pushes and never pulls. */
static inline int flank_pressing(const Flanks *f, Motion d) {
    int side = d.x > 0.0 ? 1 : -1;
    double depth = side * d.x - f->half_gap;
    return depth > 0.0 && f->stiffness * depth + f->damping * side * d.rate > 0.0 ? side : 0;
}

/* Motion of the deflection with the same flank (or none) for `time`, exact for a constant
 * acceleration of the shaft. */
static inline Motion flank_motion(const Flanks *f, int side, Motion d, double acceleration, double time) {
    if (side == 0)
        return (Motion){d.x + (d.rate + 0.5 * acceleration * time) * time, d.rate + acceleration * time};
    double edge = side * f->half_gap;
    Motion end = oscillator_after((Motion){d.x - edge, d.rate}, acceleration, f->stiffness, f->damping, time);
    return (Motion){end.x + edge, end.rate};
}

/* Time until another flank (or none) presses, at most `time`; past the change by its accuracy. */
static inline double flank_duration(const Flanks *f, int side, Motion d, double acceleration, double time) {
    if (flank_pressing(f, flank_motion(f, side, d, acceleration, time)) == side) return time;
    double same = 0.0, other = time;
    for (int i = 0; i < BACKLASH_BISECTIONS; ++i) {
        double middle = 0.5 * (same + other);
        if (flank_pressing(f, flank_motion(f, side, d, acceleration, middle)) == side)
            same = middle;
        else
            other = middle;
    }
    return other;
}

/* Substeps of at most a sixth of the contact's period: a flank is not missed however hard. */
static inline double flank_step(const Flanks *f, double step) {
    double longest = fmin(BACKLASH_STEP, 1.0 / sqrt(f->stiffness));
    return fmax(longest, 1e-3 * step);
}

/* The deflection after `time`; `touched` tells whether a flank pressed meanwhile. */
static inline Motion flank_passage(const Flanks *f, Motion d, double acceleration, double time, int *touched) {
    double left = time, longest = flank_step(f, time);
    while (left > 1e-12 * time) {
        int side = flank_pressing(f, d);
        double part = flank_duration(f, side, d, acceleration, fmin(longest, left));
        d = flank_motion(f, side, d, acceleration, part);
        *touched |= side != 0;
        left -= part;
    }
    return d;
}

/* Free play, by whether the inertia of the twin's shaft is known. */
typedef struct {
    Load load;
    Joint joint;
    int touched;                           /* in the step before */
    double position, velocity, mean, step; /* of the shaft in the step before */
} Gap;

/* The load alone, behind a shaft that moves as it did in the step before: flanks are as soft as
 * the step is long. */
static inline double backlash_behind(Load *load, const Flanks *f, double inertia, const Signals *s) {
    int touched = 0;
    Motion d = flank_passage(f, load_deflection(load, s), s->acceleration, s->step, &touched);
    return load_reaction(load, inertia, s, d);
}

/* Flanks may be hard. In the gap, the deflection follows the shaft's own position. */
static inline double backlash_between(Gap *g, const Flanks *f, double load, double shaft, const Signals *s) {
    Joint *j = &g->joint;
    if (j->running && !g->touched)
        j->deflection.x += s->position - g->position - (g->velocity + 0.5 * g->mean * g->step) * g->step;
    joint_step_begins(j, shaft, s);
    g->touched = 0;
    Motion end = flank_passage(f, j->deflection, j->push, s->step, &g->touched);
    double torque = joint_step_ends(j, end, load, shaft, s);
    g->position = s->position;
    g->velocity = s->velocity;
    g->mean = j->push + torque / shaft;
    g->step = s->step;
    return torque;
}

static inline double backlash(Gap *g, const double *v, const Signals *s) {
    double load = v[V_backlash_load_inertia], shaft = v[V_backlash_shaft_inertia];
    double stiffness = v[V_backlash_stiffness];
    if (load == 0.0 || stiffness == 0.0) return *g = (Gap){0}, 0.0;
    double inertia = shaft > 0.0 ? joint_inertia(load, shaft) : load;
    Flanks flanks = {0.5 * v[V_backlash_gap], stiffness / inertia, v[V_backlash_damping] / inertia};
    return shaft > 0.0 ? backlash_between(g, &flanks, load, shaft, s)
                       : backlash_behind(&g->load, &flanks, load, s);
}

#endif
