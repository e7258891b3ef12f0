/* Torques that repeat with the position. */
#ifndef GMFBO_PHYSICS_HARMONICS_H
#define GMFBO_PHYSICS_HARMONICS_H

#include "signals.h"

/* sine sin(angle) + cosine cos(angle); free of cost where both are zero. */
static inline double harmonic(double sine, double cosine, double angle) {
    if (sine == 0.0 && cosine == 0.0) return 0.0;
    return sine * sin(angle) + cosine * cos(angle);
}

/* The wavenumbers, sines and cosines of one effect stand in a row each in model.toml. */
static inline double harmonics(int count, const double *wavenumber, const double *sine,
                               const double *cosine, double position) {
    double sum = 0.0;
    for (int i = 0; i < count; ++i) sum += harmonic(sine[i], cosine[i], wavenumber[i] * position);
    return sum;
}

_Static_assert(V_cogging_torque_wavenumber_8 - V_cogging_torque_wavenumber_1 == 7, "in a row");
_Static_assert(V_cogging_torque_sine_8 - V_cogging_torque_sine_1 == 7, "in a row");
_Static_assert(V_cogging_torque_cosine_8 - V_cogging_torque_cosine_1 == 7, "in a row");
_Static_assert(V_torque_ripple_wavenumber_2 - V_torque_ripple_wavenumber_1 == 1, "in a row");
_Static_assert(V_torque_ripple_sine_2 - V_torque_ripple_sine_1 == 1, "in a row");
_Static_assert(V_torque_ripple_cosine_2 - V_torque_ripple_cosine_1 == 1, "in a row");

/* Pull between magnets and teeth, whatever the current. */
static inline double cogging_torque(const double *v, const Signals *s) {
    return harmonics(8, v + V_cogging_torque_wavenumber_1, v + V_cogging_torque_sine_1,
                     v + V_cogging_torque_cosine_1, s->position);
}

/* Torque constant that varies with the angle: in proportion to the current, sign and all. */
static inline double torque_ripple(const double *v, const Signals *s) {
    return s->current * harmonics(2, v + V_torque_ripple_wavenumber_1,
                                        v + V_torque_ripple_sine_1, v + V_torque_ripple_cosine_1,
                                        s->position);
}

static inline double gravity_torque(const double *v, const Signals *s) {
    return harmonic(v[V_gravity_torque_sine], v[V_gravity_torque_cosine], s->position);
}

#endif
