/* Shaft and load with the joint between them, however hard: both move within a step. */
#ifndef GMFBO_PHYSICS_JOINT_H
#define GMFBO_PHYSICS_JOINT_H

#include "oscillator.h"
#include "signals.h"

/* What pushes the shaft beside the joint is its acceleration without the joint's own torque, so
 * that the two may be moved together: a vibration or a blow then ends within the step, of which
 * the twin's shaft gets the mean torque. Its position is a little off where that torque was
 * uneven; a hard joint would answer a deflection that never was, so the deflection is kept here
 * instead of being taken from the positions. */
typedef struct {
    int running;
    Motion deflection;            /* shaft minus load at the end of the step before */
    double load_velocity, torque; /* torque on the shaft in the step before */
    double push;                  /* acceleration of the shaft without the joint */
} Joint;

/* The inertia that a deflection moves. */
static inline double joint_inertia(double load, double shaft) { return load * shaft / (load + shaft); }

static inline void joint_step_begins(Joint *j, double shaft, const Signals *s) {
    if (!j->running) *j = (Joint){.running = 1};
    j->push = s->acceleration - j->torque / shaft;
    j->deflection.rate = s->velocity - j->load_velocity;
}

/* Returns the torque on the shaft: minus the load's change of momentum over the step. */
static inline double joint_step_ends(Joint *j, Motion end, double load, double shaft, const Signals *s) {
    double change = j->push * s->step - (end.rate - j->deflection.rate);
    double impulse = change * joint_inertia(load, shaft);
    j->deflection = end;
    j->load_velocity += impulse / load;
    j->torque = -impulse / s->step;
    return j->torque;
}

#endif
