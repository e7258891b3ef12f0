/* Torque that remembers the path of the position (Maxwell slip: Masing 1926; Iwan 1966). */
#ifndef GMFBO_PHYSICS_HYSTERESIS_H
#define GMFBO_PHYSICS_HYSTERESIS_H

#include "signals.h"

#define HYSTERESIS_ELEMENTS 16

/* Travel at which each element slips, over the deflection. All slip at an equal share of the level,
 * and a first loading is 1 - exp(-travel / deflection) but for their number: the middles of
 * sixteenths of a gamma distribution of shape 2. */
static const double hysteresis_travel[HYSTERESIS_ELEMENTS] = {
    0.273582471, 0.511625898, 0.701279868, 0.876004130, 1.046251049, 1.217671020, 1.394450829, 1.580509367,
    1.780213383, 1.999098183, 2.244936372, 2.529733776, 2.874152747, 3.319418861, 3.970680333, 5.307470651};

typedef struct {
    double z[HYSTERESIS_ELEMENTS]; /* stretch of each over its travel, -1 to 1 */
} Hysteresis;

/* The value at the end of the step acts: a mass on the hysteresis then rings as one on a spring. */
static inline double hysteresis(Hysteresis *memory, const double *v, const Signals *s) {
    if (v[V_hysteresis_level] == 0.0) {
        *memory = (Hysteresis){{0.0}};
        return 0.0;
    }
    double travel = s->velocity * s->step / fmax(v[V_hysteresis_deflection], 1e-300), sum = 0.0;
    for (int i = 0; i < HYSTERESIS_ELEMENTS; ++i) {
        double z = memory->z[i] + travel / hysteresis_travel[i];
        memory->z[i] = fmin(fmax(z, -1.0), 1.0);
        sum += memory->z[i];
    }
    return -v[V_hysteresis_level] * sum / HYSTERESIS_ELEMENTS;
}

#endif
