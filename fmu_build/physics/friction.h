/* Friction laws: torque [torque port's unit] against the velocity. */
#ifndef GMFBO_PHYSICS_FRICTION_H
#define GMFBO_PHYSICS_FRICTION_H

#include "bristle.h"

/* Steps of lead (bristle.h): where the bristle only stands for a jump at rest, and where its
 * deflection is the effect. */
#define LEAD_OF_A_JUMP 4.0
#define LEAD_OF_A_SPRING 1.0

static inline double coulomb_friction(Bristle *bristle, const double *v, const Signals *s) {
    if (v[V_coulomb_friction_level] == 0.0) return bristle->bend = 0.0;
    return -v[V_coulomb_friction_level] *
           bristle_bent(bristle, v[V_coulomb_friction_deflection], LEAD_OF_A_JUMP, s);
}

/* Level between breakaway at rest and Coulomb at speed (Armstrong-Helouvry et al. 1994, eq. 2). */
static inline double stribeck_friction(Bristle *bristle, const double *v, const Signals *s) {
    double level = v[V_stribeck_friction_level], breakaway = v[V_stribeck_friction_breakaway];
    if (level == 0.0 && breakaway == 0.0) return bristle->bend = 0.0;
    double ratio = s->velocity / v[V_stribeck_friction_velocity];
    if (s->velocity == 0.0) ratio = 0.0;
    double bent = bristle_bent(bristle, v[V_stribeck_friction_deflection], LEAD_OF_A_JUMP, s);
    return -(level + (breakaway - level) * exp(-ratio * ratio)) * bent;
}

/* Dahl (1968): the deflection before sliding is what the effect shows. */
static inline double presliding_friction(Bristle *bristle, const double *v, const Signals *s) {
    if (v[V_presliding_friction_level] == 0.0) return bristle->bend = 0.0;
    return -v[V_presliding_friction_level] *
           bristle_bent(bristle, v[V_presliding_friction_deflection], LEAD_OF_A_SPRING, s);
}

/* One level a direction: a bristle that is as stiff on both sides, and yields earlier on one. Under
 * noise that shakes the axis both levels act in turn, and what is left of them is half their
 * difference, as of friction that jumps. Lubrication may differ by direction as well: half the
 * difference of the viscous coefficients acts against the positive direction, half with the
 * negative one. */
static inline double asymmetric_friction(Bristle *bristle, const double *v, const Signals *s) {
    double positive = v[V_asymmetric_friction_level_positive];
    double negative = v[V_asymmetric_friction_level_negative];
    double viscous = -0.5 * v[V_asymmetric_friction_viscous_difference] * fabs(s->velocity);
    if (positive == 0.0 && negative == 0.0) {
        bristle->bend = 0.0;
        return viscous;
    }
    double mean = 0.5 * (positive + negative), skew = 0.5 * (positive - negative) / mean;
    double deflection = v[V_asymmetric_friction_deflection];
    return viscous - mean * bristle_bent_askew(bristle, skew, deflection, LEAD_OF_A_JUMP, s);
}

/* Level grows with the load that the bearing and the gear transmit. */
static inline double load_dependent_friction(Bristle *bristle, const double *v, const Signals *s) {
    double level = v[V_load_dependent_friction_level];
    double coefficient = v[V_load_dependent_friction_coefficient];
    if (level == 0.0 && coefficient == 0.0) return bristle->bend = 0.0;
    double bent =
        bristle_bent(bristle, v[V_load_dependent_friction_deflection], LEAD_OF_A_JUMP, s);
    return -(level + coefficient * fabs(s->load_torque)) * bent;
}

static inline double position_dependent_friction(Bristle *bristle, const double *v, const Signals *s) {
    double level = v[V_position_dependent_friction_level];
    double sine = v[V_position_dependent_friction_sine];
    double cosine = v[V_position_dependent_friction_cosine];
    if (level == 0.0 && sine == 0.0 && cosine == 0.0) return bristle->bend = 0.0;
    double angle = v[V_position_dependent_friction_wavenumber] * s->position;
    double bent =
        bristle_bent(bristle, v[V_position_dependent_friction_deflection], LEAD_OF_A_JUMP, s);
    return -fmax(0.0, level + sine * sin(angle) + cosine * cos(angle)) * bent;
}

static inline double viscous_friction(const double *v, const Signals *s) {
    return -v[V_viscous_friction_coefficient] * s->velocity;
}

static inline double quadratic_drag(const double *v, const Signals *s) {
    return -v[V_quadratic_drag_coefficient] * s->velocity * fabs(s->velocity);
}

#endif
