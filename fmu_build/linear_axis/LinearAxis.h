/* LinearAxis.mo, SHA-256 2052e4669e10c08a03e0a204ed3b557d6c5be48dcb9d52c8618501033375419e: translated by the package modelica. */
#ifndef GMFBO_LINEARAXIS_H
#define GMFBO_LINEARAXIS_H

enum {
    STATE_position,
    STATE_velocity,
    N_STATE
};

enum {
    PARAMETER_mass,
    PARAMETER_viscous_friction,
    PARAMETER_force_gain,
    PARAMETER_voltage,
    PARAMETER_port_force,
    N_PARAMETER
};

enum {
    OBSERVED_mass,
    OBSERVED_viscous_friction,
    OBSERVED_force_gain,
    OBSERVED_voltage,
    OBSERVED_port_force,
    OBSERVED_position,
    OBSERVED_velocity,
    OBSERVED_der_velocity,
    OBSERVED_force,
    OBSERVED_der_position,
    N_OBSERVED
};

enum { N_WORKSPACE = 10 };

/* t: time, y: states, p: parameters and inputs, w: workspace, dy: derivatives of y. */
void rhs(double t, const double *y, const double *p, double *w, double *dy);
void observe(double t, const double *y, const double *p, double *w, double *out);

#endif
