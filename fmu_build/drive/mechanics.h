/* Rotor and load, joined rigidly or through an elastic shaft with backlash; all at the joint. */
#ifndef GMFBO_DRIVE_MECHANICS_H
#define GMFBO_DRIVE_MECHANICS_H

#include <math.h>

#include "friction.h"

typedef struct {
    int flexible;
    double motor_inertia, load_inertia;  /* [kg.m2] */
    double stiffness, damping, backlash; /* [N.m/rad], [N.m.s/rad], [rad] full gap */
    double friction_scale;
    double motor_viscous, load_viscous;  /* [N.m.s/rad], the motor's before scaling */
    DryFriction motor_friction, load_friction; /* before scaling */
    double unbalance, unbalance_angle;   /* [N.m], [rad] */
} Mechanics;

/* Torque [N.m] of the load's weight: unbalance times the sine of its angle to the vertical. */
static inline double unbalance_torque(const Mechanics *mechanics, double angle) {
    if (mechanics->unbalance == 0.0) return 0.0;
    return -mechanics->unbalance * sin(angle + mechanics->unbalance_angle);
}

/* Torque [N.m] from rotor to load. Inside the gap there is none; damping comes in with the depth
 * of contact, so that the torque is continuous, and a contact cannot pull. */
static inline double shaft_torque(const Mechanics *mechanics, double twist, double twist_rate) {
    double half_gap = 0.5 * mechanics->backlash;
    double depth = fabs(twist) - half_gap;
    if (depth <= 0.0) return 0.0;
    double grip = half_gap > 0.0 ? depth / (depth + 0.2 * half_gap) : 1.0;
    double torque = mechanics->stiffness * copysign(depth, twist) + mechanics->damping * grip * twist_rate;
    return half_gap > 0.0 && torque * twist < 0.0 ? 0.0 : torque;
}

#endif
