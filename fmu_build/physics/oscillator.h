/* Exact motion of a damped oscillator under a constant push. */
#ifndef GMFBO_PHYSICS_OSCILLATOR_H
#define GMFBO_PHYSICS_OSCILLATOR_H

#include <math.h>

typedef struct {
    double x, rate;
} Motion;

/* x'' = push - stiffness x - damping x' after `time`, stiffness > 0 and damping >= 0 divided by the
 * inertia; underdamped, critical and overdamped. */
static inline Motion oscillator_after(Motion m, double push, double stiffness, double damping,
                                      double time) {
    double decay = 0.5 * damping, discriminant = stiffness - decay * decay, cosine, sine;
    if (discriminant > 0.0) {
        double w = sqrt(discriminant), fade = exp(-decay * time);
        cosine = fade * cos(w * time);
        sine = fade * sin(w * time) / w;
    } else {
        double w = sqrt(-discriminant);
        double slow = exp((w - decay) * time), fast = exp((-w - decay) * time);
        cosine = 0.5 * (slow + fast);
        sine = w * time > 1e-8 ? 0.5 * (slow - fast) / w : slow * time;
    }
    double rest = push / stiffness, x = m.x - rest;
    return (Motion){rest + cosine * x + sine * (m.rate + decay * x),
                    cosine * m.rate - sine * (decay * m.rate + stiffness * x)};
}

#endif
