/* Command port: effects that come late. The command is held over each step, as a sampled controller
 * gives it, and so each returns the exact mean of its answer over the step: the impulse that reaches
 * the plant does not depend on the step. */
#ifndef GMFBO_PHYSICS_TIMING_H
#define GMFBO_PHYSICS_TIMING_H

#include "signals.h"

typedef struct {
    int running;
    double value; /* at the start of the step */
} Follower;

/* First order: y(t + s) = u + (y(t) - u) exp(-s / time). */
static inline double actuator_lag(Follower *lag, const double *v, const Signals *s, double u) {
    double time = v[V_actuator_lag_time];
    if (time == 0.0) return lag->running = 0, u;
    if (!lag->running) *lag = (Follower){1, u};
    double x = s->step / time, gap = lag->value - u, gone = -expm1(-x);
    lag->value = u + gap * (1.0 - gone);
    return u + gap * gone / x;
}

/* The value moves to u along a straight line. */
static inline double actuator_rate_limit(Follower *slope, const double *v, const Signals *s, double u) {
    double rate = v[V_actuator_rate_limit_rate];
    if (rate == 0.0) return slope->running = 0, u;
    if (!slope->running) *slope = (Follower){1, u};
    double gap = u - slope->value, reach = rate * s->step;
    if (fabs(gap) <= reach) {
        slope->value = u;
        return u - 0.5 * gap * fabs(gap) / reach;
    }
    slope->value += copysign(reach, gap);
    return slope->value - copysign(0.5 * reach, gap);
}

#define DELAY_STEPS 2048 /* 0.1 s at steps of 50 us */
#define DELAY_REACH (DELAY_STEPS - 2)

/* Ring of the steps' start times and commands. */
typedef struct {
    int count, newest;
    double time[DELAY_STEPS], value[DELAY_STEPS];
} DelayLine;

static inline int delay_index(const DelayLine *line, int steps_ago) {
    return (line->newest - steps_ago + DELAY_STEPS) % DELAY_STEPS;
}

static inline void delay_store(DelayLine *line, double time, double value) {
    line->newest = (line->newest + 1) % DELAY_STEPS;
    line->time[line->newest] = time;
    line->value[line->newest] = value;
    if (line->count < DELAY_STEPS) ++line->count;
}

/* How many steps ago the step began that holds `time`; the oldest one if none is that old. */
static inline int delay_find(const DelayLine *line, double time, double step) {
    double guess = floor((line->time[line->newest] - time) / step);
    int ago = guess < 0.0 ? 0 : guess < line->count - 1 ? (int)guess : line->count - 1;
    while (ago > 0 && line->time[delay_index(line, ago - 1)] <= time) --ago;
    while (ago < line->count - 1 && line->time[delay_index(line, ago)] > time) ++ago;
    return ago;
}

/* Mean of the command over the step `delay` earlier: for equal steps the straight line between the
 * two commands held then. */
static inline double transport_delay(DelayLine *line, const double *v, const Signals *s, double u) {
    double delay = v[V_transport_delay_delay];
    if (delay == 0.0) return line->count = 0, u;
    delay_store(line, s->time, u);
    double from = s->time - delay, to = from + s->step, sum = 0.0;
    for (int ago = delay_find(line, from, s->step); from < to; --ago) {
        double until = ago > 0 ? fmin(line->time[delay_index(line, ago - 1)], to) : to;
        sum += line->value[delay_index(line, ago)] * (until - from);
        from = until;
    }
    return sum / s->step;
}

#endif
