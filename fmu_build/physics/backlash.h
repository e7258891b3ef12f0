/* Free play: a load between two elastic flanks on the twin's shaft. */
#ifndef GMFBO_PHYSICS_BACKLASH_H
#define GMFBO_PHYSICS_BACKLASH_H

#include "load.h"

#define BACKLASH_STEP 20e-6    /* [s] touch and release are looked for this often */
#define BACKLASH_BISECTIONS 12 /* and found to a part of it: 5 ns */

/* By the load's inertia. */
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

static inline double backlash(Load *load, const double *v, const Signals *s) {
    double inertia = v[V_backlash_load_inertia], stiffness = v[V_backlash_stiffness];
    if (inertia == 0.0 || stiffness == 0.0) return load->running = 0, 0.0;
    Flanks flanks = {0.5 * v[V_backlash_gap], stiffness / inertia, v[V_backlash_damping] / inertia};
    Motion d = load_deflection(load, s);
    double left = s->step, longest = flank_step(&flanks, s->step);
    while (left > 1e-12 * s->step) {
        int side = flank_pressing(&flanks, d);
        double time = flank_duration(&flanks, side, d, s->acceleration, fmin(longest, left));
        d = flank_motion(&flanks, side, d, s->acceleration, time);
        left -= time;
    }
    return load_reaction(load, inertia, s, d);
}

#endif
