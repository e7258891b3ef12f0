/* An inertia that the twin leaves out: on its shaft, or behind a spring. */
#ifndef GMFBO_PHYSICS_LOAD_H
#define GMFBO_PHYSICS_LOAD_H

#include "joint.h"
#include "oscillator.h"
#include "signals.h"

/* The load in the coordinates of the twin's shaft. */
typedef struct {
    int running;
    double position, velocity;
} Load;

/* Shaft minus load; at the first step the load rests where the shaft is. */
static inline Motion load_deflection(Load *load, const Signals *s) {
    if (!load->running) *load = (Load){1, s->position, 0.0};
    return (Motion){s->position - load->position, s->velocity - load->velocity};
}

/* The load moves on to the end of the step; returned is the torque on the shaft, which is minus
 * the load's change of momentum over the step: their momentum together is kept exactly. The shaft
 * moves with the acceleration of the step before. */
static inline double load_reaction(Load *load, double inertia, const Signals *s, Motion deflection) {
    double shaft = s->velocity + s->acceleration * s->step, before = load->velocity;
    load->position = s->position + 0.5 * (s->velocity + shaft) * s->step - deflection.x;
    load->velocity = shaft - deflection.rate;
    return -inertia * (load->velocity - before) / s->step;
}

/* Load behind a spring and a damper, by whether the inertia of the twin's shaft is known. */
typedef struct {
    Load load;
    Joint joint;
} Spring;

static inline double torsional_compliance(Spring *m, const double *v, const Signals *s) {
    double load = v[V_torsional_compliance_load_inertia], shaft = v[V_torsional_compliance_shaft_inertia];
    double stiffness = v[V_torsional_compliance_stiffness];
    if (load == 0.0 || stiffness == 0.0) return *m = (Spring){0}, 0.0;
    double damping = v[V_torsional_compliance_damping];
    if (shaft > 0.0) {
        double inertia = joint_inertia(load, shaft);
        Joint *j = &m->joint;
        joint_step_begins(j, shaft, s);
        Motion end = oscillator_after(j->deflection, j->push, stiffness / inertia, damping / inertia, s->step);
        return joint_step_ends(j, end, load, shaft, s);
    }
    Motion end = oscillator_after(load_deflection(&m->load, s), s->acceleration, stiffness / load,
                                  damping / load, s->step);
    return load_reaction(&m->load, load, s, end);
}

/* First-order mean of the acceleration over the last steps. */
typedef struct {
    double acceleration;
} Inertia;

#define INERTIA_FILTER_STEPS 3.0

/* Held for a step, the torque follows the acceleration that it changes: the filter keeps this loop
 * stable up to six times the twin's own inertia. */
static inline double load_inertia(Inertia *memory, const double *v, const Signals *s) {
    if (v[V_load_inertia_inertia] == 0.0) return memory->acceleration = 0.0;
    memory->acceleration += -expm1(-1.0 / INERTIA_FILTER_STEPS) * (s->acceleration - memory->acceleration);
    return -v[V_load_inertia_inertia] * memory->acceleration;
}

#endif
