/* Command port: what limits or bends the command at once. Each takes a command, returns the next. */
#ifndef GMFBO_PHYSICS_LIMITS_H
#define GMFBO_PHYSICS_LIMITS_H

#include "signals.h"

static inline double clip(double value, double limit) { return fmin(fmax(value, -limit), limit); }

static inline double actuator_gain_loss(const double *v, double u) {
    return u - v[V_actuator_gain_loss_loss] * u;
}

static inline double actuator_dead_zone(const double *v, double u) {
    double width = v[V_actuator_dead_zone_width];
    return width == 0.0 ? u : u - clip(u, width);
}

static inline double actuator_saturation(const double *v, double u) {
    double limit = v[V_actuator_saturation_limit];
    return limit == 0.0 ? u : clip(u, limit);
}

/* The back-EMF takes from the voltage that accelerates, and adds to the one that brakes. */
static inline double supply_voltage_limit(const double *v, const Signals *s, double u) {
    double limit = v[V_supply_voltage_limit_limit];
    if (limit == 0.0) return u;
    double back = v[V_supply_voltage_limit_slope] * s->velocity;
    return fmin(fmax(u, -limit - back), limit - back);
}

/* Torque falls behind the current as iron saturates. */
static inline double magnetic_saturation(const double *v, double u) {
    double bend = v[V_magnetic_saturation_coefficient] * u;
    return u / (1.0 + bend * bend);
}

#endif
