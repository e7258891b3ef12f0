/* Torque that remembers the path of the position (Bouc 1967; Wen 1976). */
#ifndef GMFBO_PHYSICS_HYSTERESIS_H
#define GMFBO_PHYSICS_HYSTERESIS_H

#include "signals.h"

typedef struct {
    double z; /* part of the level, -1 to 1 */
} Hysteresis;

#define HYSTERESIS_STEP 0.1   /* of travel over deflection */
#define HYSTERESIS_REACH 25.0 /* behind it z is 1 to rounding, for any exponent of 1 or more */

/* z after a travel > 0 in units of the deflection, z counted along the travel: dz = 1 on the way
 * back to zero, then dz = 1 - z^n; exact for n = 1, else by steps that are exact for the tangent
 * (second order, and never past 1). */
static inline double hysteresis_after(double z, double travel, double n) {
    double back = fmin(fmax(-z, 0.0), travel);
    z += back;
    travel = fmin(travel - back, HYSTERESIS_REACH);
    if (n == 1.0) return 1.0 + (z - 1.0) * exp(-travel);
    int steps = (int)ceil(travel / HYSTERESIS_STEP);
    for (int i = 0; i < steps && z < 1.0; ++i) {
        double power = pow(z, n - 1.0), slope = n * power, x = slope * travel / steps;
        double share = x > 1e-8 ? -expm1(-x) / slope : travel / steps;
        z = fmin(1.0, z + (1.0 - power * z) * share);
    }
    return z;
}

/* The value at the end of the step acts: a mass on the hysteresis then rings as one on a spring. */
static inline double hysteresis(Hysteresis *memory, const double *v, const Signals *s) {
    if (v[V_hysteresis_level] == 0.0) return memory->z = 0.0;
    double travel = s->velocity * s->step, way = copysign(1.0, travel);
    double length = fmin(fabs(travel) / v[V_hysteresis_deflection], 2.0 + HYSTERESIS_REACH);
    if (travel != 0.0)
        memory->z = way * hysteresis_after(way * memory->z, length, v[V_hysteresis_exponent]);
    return -v[V_hysteresis_level] * memory->z;
}

#endif
