/* When a sampled controller computes. */
#ifndef GMFBO_SAMPLING_H
#define GMFBO_SAMPLING_H

#include <float.h>
#include <math.h>

/* Sample instants are origin + k * period, where origin is the time of the first step. */
typedef struct {
    double origin; /* [s] */
    double period; /* [s] */
    double next;   /* index k of the next instant; a double counts exactly to 2^53 */
    int started;
} Sampler;

/* Two times closer than this are one instant: the master computes t0 + i h with its own rounding. */
static inline double sampler_tolerance(const Sampler *sampler, double t) {
    return 1e-9 * sampler->period + 4.0 * DBL_EPSILON * fabs(t);
}

static inline double sampler_next(const Sampler *sampler) {
    return sampler->origin + sampler->next * sampler->period;
}

/* Whether an instant is reached at t; it is then counted as done. */
static inline int sampler_due(Sampler *sampler, double t) {
    if (!sampler->started) {
        sampler->origin = t;
        sampler->started = 1;
    }
    if (t < sampler_next(sampler) - sampler_tolerance(sampler, t)) return 0;
    sampler->next += 1.0;
    return 1;
}

/* The next instant, or `end` where that comes first or is the same. */
static inline double sampler_until(const Sampler *sampler, double end) {
    double next = sampler_next(sampler);
    return next < end - sampler_tolerance(sampler, end) ? next : end;
}

#endif
