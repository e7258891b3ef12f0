/* Torques without memory of the motion: springs, offsets, and those that come with the time. */
#ifndef GMFBO_PHYSICS_FORCES_H
#define GMFBO_PHYSICS_FORCES_H

#include "signals.h"

static inline double elastic_return(const double *v, const Signals *s) {
    return v[V_elastic_return_preload] - v[V_elastic_return_stiffness] * s->position;
}

static inline double constant_torque_offset(const double *v) {
    return v[V_constant_torque_offset_level];
}

/* Mean over the step, so that its impulse is exact: the middle's value times sin(x)/x. */
static inline double periodic_disturbance(const double *v, const Signals *s) {
    double sine = v[V_periodic_disturbance_sine], cosine = v[V_periodic_disturbance_cosine];
    if (sine == 0.0 && cosine == 0.0) return 0.0;
    double rate = 6.283185307179586 * v[V_periodic_disturbance_frequency];
    double half = 0.5 * rate * s->step, middle = rate * (s->time + 0.5 * s->step);
    double share = half != 0.0 ? sin(half) / half : 1.0;
    return share * (sine * sin(middle) + cosine * cos(middle));
}

/* Mean over the step: the share of it that lies within the pulse. */
static inline double pulse_disturbance(const double *v, const Signals *s) {
    if (v[V_pulse_disturbance_level] == 0.0) return 0.0;
    double start = v[V_pulse_disturbance_start];
    double from = fmax(s->time, start);
    double to = fmin(s->time + s->step, start + v[V_pulse_disturbance_duration]);
    return to > from ? v[V_pulse_disturbance_level] * fmin(1.0, (to - from) / s->step) : 0.0;
}

#endif
