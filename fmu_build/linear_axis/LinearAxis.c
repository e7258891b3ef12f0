/* LinearAxis.mo, SHA-256 2052e4669e10c08a03e0a204ed3b557d6c5be48dcb9d52c8618501033375419e: translated by the package modelica. */
#include "LinearAxis.h"

#pragma GCC diagnostic ignored "-Wunused-parameter"
#pragma GCC diagnostic ignored "-Wunused-variable"
#pragma GCC diagnostic ignored "-Wunused-but-set-variable"
/* Generated from LinearAxis by modelica.sim.cgen. Do not edit. */
#include <math.h>

#define MD_UNUSED __attribute__((unused))

MD_UNUSED static inline double md_mod(double a, double b) {
    double r = fmod(a, b);
    return (r != 0.0 && (r < 0.0) != (b < 0.0)) ? r + b : r;
}

MD_UNUSED static inline double md_min(double a, double b) { return a < b ? a : b; }
MD_UNUSED static inline double md_max(double a, double b) { return a > b ? a : b; }
MD_UNUSED static inline double md_sign(double a) { return (double)((a > 0.0) - (a < 0.0)); }

/* Dense LU with partial pivoting: the linear blocks are two- and three-by-two, and a
   BLAS dependency for that would be a build system in exchange for nothing. */
MD_UNUSED static inline void md_solve(int n, double *a, double *b, double *x) {
    for (int k = 0; k < n; ++k) {
        int pivot = k;
        for (int i = k + 1; i < n; ++i) {
            if (fabs(a[i * n + k]) > fabs(a[pivot * n + k])) { pivot = i; }
        }
        if (pivot != k) {
            for (int j = 0; j < n; ++j) {
                double swap = a[k * n + j];
                a[k * n + j] = a[pivot * n + j];
                a[pivot * n + j] = swap;
            }
            double swap = b[k]; b[k] = b[pivot]; b[pivot] = swap;
        }
        for (int i = k + 1; i < n; ++i) {
            double factor = a[i * n + k] / a[k * n + k];
            a[i * n + k] = 0.0;
            for (int j = k + 1; j < n; ++j) { a[i * n + j] -= factor * a[k * n + j]; }
            b[i] -= factor * b[k];
        }
    }
    for (int i = n - 1; i >= 0; --i) {
        double total = b[i];
        for (int j = i + 1; j < n; ++j) { total -= a[i * n + j] * x[j]; }
        x[i] = total / a[i * n + i];
    }
}

void rhs(double t, const double *y, const double *p, double *w, double *dy) {
    double der_velocity;
    double force_gain;
    double mass;
    double port_force;
    double velocity;
    double viscous_friction;
    double voltage;
    mass = p[0];
    viscous_friction = p[1];
    force_gain = p[2];
    voltage = p[3];
    port_force = p[4];
    velocity = y[1];
    der_velocity = -(-(force_gain * voltage + port_force - viscous_friction * velocity) / mass);
    dy[0] = velocity;
    dy[1] = der_velocity;
}

void observe(double t, const double *y, const double *p, double *w, double *out) {
    double der_position;
    double der_velocity;
    double force;
    double force_gain;
    double mass;
    double port_force;
    double position;
    double velocity;
    double viscous_friction;
    double voltage;
    mass = p[0];
    viscous_friction = p[1];
    force_gain = p[2];
    voltage = p[3];
    port_force = p[4];
    position = y[0];
    velocity = y[1];
    der_velocity = -(-(force_gain * voltage + port_force - viscous_friction * velocity) / mass);
    force = force_gain * voltage;
    der_position = velocity;
    out[0] = mass;
    out[1] = viscous_friction;
    out[2] = force_gain;
    out[3] = voltage;
    out[4] = port_force;
    out[5] = position;
    out[6] = velocity;
    out[7] = der_velocity;
    out[8] = force;
    out[9] = der_position;
}

void indicators(double t, const double *y, const double *p, double *w, double *z) {
}

void transition(int event, double t, const double *y, const double *p, double *w, double *out) {
    out[0] = y[0];
    out[1] = y[1];
}

void jacobian(double t, const double *y, const double *p, double *w, double *out) {
    double mass;
    double viscous_friction;
    mass = p[0];
    viscous_friction = p[1];
    double _d_velocity[2] = {0};
    _d_velocity[1] = 1.0;
    double _d_der_velocity[2] = {0};
    for (int _k = 0; _k < 2; ++_k) {
        _d_der_velocity[_k] = -(viscous_friction * mass / pow(mass, 2.0)) * _d_velocity[_k];
    }
    for (int _k = 0; _k < 2; ++_k) {
        out[0 * 2 + _k] = _d_velocity[_k];
    }
    for (int _k = 0; _k < 2; ++_k) {
        out[1 * 2 + _k] = _d_der_velocity[_k];
    }
}

