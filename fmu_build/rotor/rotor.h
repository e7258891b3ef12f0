/* One rotating mass with viscous friction under a torque that follows its command with a
 * first-order lag; linear, so that a step of any length is exact. */
#ifndef GMFBO_ROTOR_H
#define GMFBO_ROTOR_H

#include <math.h>

typedef struct {
    double position; /* [rad] */
    double velocity; /* [rad/s] */
    double torque;   /* [N.m] of the drive, on the shaft */
} Rotor;

typedef struct {
    double inertia;  /* [kg.m2] */
    double viscous;  /* [N.m.s/rad] */
    double lag_rate; /* [1/s] of the torque behind its command; 0 holds the torque */
} RotorParameters;

/* Taylor series of the exact solution over pieces of at most half of the fastest time constant:
 * the first term left out is below 0.5^17/17! = 2e-20 of the state. */
static inline void rotor_advance(Rotor *r, const RotorParameters *p, double torque_command, double load,
                                 double duration) {
    double friction_rate = p->viscous / p->inertia;
    double pieces = fmax(1.0, ceil(2.0 * duration * fmax(p->lag_rate, friction_rate)));
    double h = duration / pieces;
    for (double piece = 0.0; piece < pieces; piece += 1.0) {
        Rotor term = *r;
        double forced_torque = p->lag_rate * torque_command, forced_rate = load / p->inertia;
        for (int n = 1; n <= 16; ++n) {
            double share = h / n;
            Rotor next = {
                share * term.velocity,
                share * (term.torque / p->inertia - friction_rate * term.velocity + forced_rate),
                share * (forced_torque - p->lag_rate * term.torque),
            };
            r->position += next.position;
            r->velocity += next.velocity;
            r->torque += next.torque;
            term = next;
            forced_torque = forced_rate = 0.0; /* held inputs enter the first derivative only */
        }
    }
}

#endif
