/* Command port: the motor gives less torque as it warms up. */
#ifndef GMFBO_PHYSICS_THERMAL_H
#define GMFBO_PHYSICS_THERMAL_H

#include "signals.h"

typedef struct {
    double heat; /* of the final temperature under the current `scale` */
} Warming;

/* time d heat/dt = (i / scale)^2 - heat, exact for the held current. */
static inline double thermal_derating(Warming *motor, const double *v, const Signals *s, double u) {
    double loss = v[V_thermal_derating_loss], scale = v[V_thermal_derating_scale];
    if (loss == 0.0 || scale == 0.0) return motor->heat = 0.0, u;
    double final = (s->current / scale) * (s->current / scale);
    double acting = u * (1.0 - loss * motor->heat);
    motor->heat = final + (motor->heat - final) * exp(-s->step / v[V_thermal_derating_time]);
    return acting;
}

#endif
