/* Classical Runge-Kutta steps of the axis, cut where the velocity of a surface with friction
 * meets zero; there it sticks, or slips the other way. */
#ifndef GMFBO_DEMO_AXIS_INTEGRATION_H
#define GMFBO_DEMO_AXIS_INTEGRATION_H

#include "hidden.h"

#define INNER_STEP 2e-5 /* [s] a fifth of the shortest lag of the torque */

typedef struct {
    double x[N_STATES];
    double command; /* [N.m] that has reached the drive */
    int stuck, direction;
} Axis;

static inline void slope(const Axis *a, const Hidden *p, double t, const double *x, double *dx) {
    double passed = drive(p, a->command);
    if (p->lag > 0.0) dx[LAGGED] = (passed - x[LAGGED]) / p->lag;
    if (p->lag > 0.0) passed = x[LAGGED];
    dx[TORQUE] = (passed - x[TORQUE]) / p->torque_lag;
    if (p->load_inertia > 0.0) {
        dx[LOAD_Q] = x[LOAD_W];
        dx[LOAD_W] = transmitted(p, x) / p->load_inertia;
    }
    if (a->stuck) return;
    double friction = a->direction ? a->direction * friction_level(p, x[W], a->direction) : 0.0;
    dx[Q] = x[W];
    dx[W] = (applied(p, t, x) - friction) / (p->inertia - p->load_inertia);
}

static inline void runge_kutta(const Axis *a, const Hidden *p, double t, double h, double *end) {
    static const double at[] = {0.0, 0.5, 0.5, 1.0}, weight[] = {1.0, 2.0, 2.0, 1.0};
    double k[N_STATES] = {0}, x[N_STATES], sum[N_STATES] = {0};
    for (int stage = 0; stage < 4; ++stage) {
        for (int i = 0; i < N_STATES; ++i) x[i] = a->x[i] + at[stage] * h * k[i];
        memset(k, 0, sizeof k);
        slope(a, p, t + at[stage] * h, x, k);
        for (int i = 0; i < N_STATES; ++i) sum[i] += weight[stage] * k[i];
    }
    for (int i = 0; i < N_STATES; ++i) end[i] = a->x[i] + h / 6.0 * sum[i];
}

/* A surface at rest sticks, or begins to slip where the torque pushes it. */
static inline void settle(Axis *a, const Hidden *p, double t) {
    double torque = applied(p, t, a->x);
    a->direction = torque < 0.0 ? -1 : 1;
    a->stuck = fabs(torque) <= friction_level(p, 0.0, a->direction);
}

/* Share of a step at which the velocity has just gone through zero. */
static inline double crossing(const Axis *a, const Hidden *p, double t, double h, double *end) {
    double low = 0.0, high = h;
    for (int i = 0; i < 40; ++i) {
        double middle = 0.5 * (low + high);
        runge_kutta(a, p, t, middle, end);
        *(end[W] * a->direction > 0.0 ? &low : &high) = middle;
    }
    runge_kutta(a, p, t, high, end);
    end[W] = 0.0;
    return high;
}

/* One smooth piece of at most h; answers its length. */
static inline double piece(Axis *a, const Hidden *p, double t, double h) {
    double end[N_STATES];
    int rubs = has_friction(p);
    if (!rubs) a->stuck = a->direction = 0;
    if (rubs && a->x[W] == 0.0) settle(a, p, t);
    else if (rubs) a->direction = a->x[W] < 0.0 ? -1 : 1;
    runge_kutta(a, p, t, h, end);
    if (rubs && !a->stuck && end[W] * a->direction <= 0.0) {
        if (a->x[W] == 0.0) { /* pushed back within the step: it rests through it */
            a->stuck = 1;
            runge_kutta(a, p, t, h, end);
        } else {
            h = crossing(a, p, t, h, end);
        }
    }
    memcpy(a->x, end, sizeof end);
    return h;
}

static inline void axis_advance(Axis *a, const Hidden *p, double t, double duration) {
    double steps = ceil(duration / INNER_STEP - 1e-9), h = duration / steps;
    for (double k = 0.0; k < steps; k += 1.0) {
        double done = 0.0;
        while (done < h * (1.0 - 1e-9)) done += piece(a, p, t + k * h + done, h - done);
    }
}

#endif
