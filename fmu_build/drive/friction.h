/* Dry friction with presliding: an elastic bristle that yields at the Stribeck curve. */
#ifndef GMFBO_DRIVE_FRICTION_H
#define GMFBO_DRIVE_FRICTION_H

#include <math.h>

typedef struct {
    double coulomb;           /* [N.m] level at speed */
    double stribeck;          /* [N.m] excess of the breakaway level over it */
    double stribeck_velocity; /* [rad/s] */
    double presliding;        /* [rad] deflection at which the Coulomb level would be reached */
} DryFriction;

/* Steady-state friction at a speed [N.m] (Stribeck curve; Armstrong-Helouvry et al. 1994). */
static inline double friction_level(const DryFriction *friction, double velocity) {
    if (friction->stribeck == 0.0) return friction->coulomb;
    double ratio = velocity / friction->stribeck_velocity;
    return friction->coulomb + friction->stribeck * exp(-ratio * ratio);
}

/* Friction torque [N.m] after `duration` at a constant velocity.
 *
 * df/dt = sigma (v - |v| f / level(v)), sigma = (coulomb + stribeck) / presliding (Dahl 1968;
 * Canudas de Wit et al. 1995 without bristle damping). Linear in f while v is held, so it is
 * solved exactly: stable for any step, and a shaft at rest keeps its friction. */
static inline double friction_after(const DryFriction *friction, double torque, double velocity,
                                    double duration) {
    double stiffness = (friction->coulomb + friction->stribeck) / friction->presliding;
    if (stiffness == 0.0) return 0.0;
    double level = copysign(friction_level(friction, velocity), velocity);
    if (level == 0.0) return velocity == 0.0 ? torque : 0.0;
    return level + (torque - level) * exp(-stiffness * velocity / level * duration);
}

#endif
