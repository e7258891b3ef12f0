/* The elastic bristle that every dry friction law bends. */
#ifndef GMFBO_PHYSICS_BRISTLE_H
#define GMFBO_PHYSICS_BRISTLE_H

#include "signals.h"

typedef struct {
    double bend; /* part of the yield level that is reached, -1 to 1 */
} Bristle;

/* Part of the level, -1 to 1, that acts over the step; the friction force is minus level times it.
 *
 * Dahl (1968): d bend/dt = (v - |v| bend) / deflection, solved exactly for the held velocity, so
 * that any step is stable and sliding ends in exactly 1.
 *
 * The force is held while a mass J under it moves, which for stiffness k = level / deflection is
 * an oscillator with k h^2 / J = a. `lead` steps of the bend's own change are added, as the
 * bristle damping of Canudas de Wit et al. (1995) does: with the poles of
 *     z^2 - (2 - a (lead + 1)) z + 1 - a lead
 * lead = 0 rings for ever, lead = 4 rests within some ten steps at a = 0.1 and is stable up to
 * a = 0.44. The sum keeps to the level, so that a reversal within a step is no kick.
 *
 * Askew, sliding ends at skew + 1 and skew - 1, and the bend begins at rest all the same. */
static inline double bristle_bent_askew(
    Bristle *bristle, double skew, double deflection, double lead, const Signals *s) {
    double travel = s->velocity * s->step, before = bristle->bend, end = skew + copysign(1.0, travel);
    if (travel == 0.0) return before;
    bristle->bend = deflection > 0.0 ? end + (before - end) * exp(-fabs(travel) / deflection) : end;
    double bent = bristle->bend + lead * (bristle->bend - before);
    return fmin(fmax(bent, skew - 1.0), skew + 1.0);
}

static inline double bristle_bent(Bristle *bristle, double deflection, double lead, const Signals *s) {
    return bristle_bent_askew(bristle, 0.0, deflection, lead, s);
}

#endif
