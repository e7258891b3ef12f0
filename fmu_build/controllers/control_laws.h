/* Parts that the sampled controllers share. */
#ifndef GMFBO_CONTROL_LAWS_H
#define GMFBO_CONTROL_LAWS_H

#include <math.h>

#include "sampling.h"

/* Difference of a sampled signal behind a first-order low pass, by the backward Euler rule:
 * d_k = (T_f d_{k-1} + x_k - x_{k-1}) / (T_f + T_s). */
typedef struct {
    double previous, value;
    int started;
} Derivative;

/* The first sample has no predecessor: its difference is zero. */
static inline double derivative_next(Derivative *d, double x, double filter_time, double sample_time) {
    double difference = d->started ? x - d->previous : 0.0;
    d->value = (filter_time * d->value + difference) / (filter_time + sample_time);
    d->previous = x;
    d->started = 1;
    return d->value;
}

static inline double limited(double value, double low, double high) { return fmin(fmax(value, low), high); }

/* Integral by the forward Euler rule with back-calculation (Astrom, Hagglund 2006, section 3.5):
 * I_{k+1} = I_k + T_s (k_i e_k + k_t (u_k - u_raw_k)), k_t no faster than one sample. */
static inline double integral_next(double integral, double integrand, double excess, double anti_windup_gain,
                                   double sample_time) {
    double rate = fmin(anti_windup_gain, 1.0 / sample_time);
    return integral + sample_time * (integrand - rate * excess);
}

#endif
