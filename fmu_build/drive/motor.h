/* Permanent-magnet synchronous motor in its rotor's dq frame, seen through a gear. */
#ifndef GMFBO_DRIVE_MOTOR_H
#define GMFBO_DRIVE_MOTOR_H

#include <math.h>

#include "sine.h"

enum { COGGING_HARMONICS = 2 };

typedef struct {
    double resistance;  /* [Ohm] */
    double pole_pairs;
    double flux;        /* [Wb] of the magnets */
    double gear_ratio;
    double cogging_amplitude[COGGING_HARMONICS]; /* [N.m] at the joint */
    double cogging_order[COGGING_HARMONICS];     /* [1/rad] periods a radian of the joint */
    double cogging_phase[COGGING_HARMONICS];     /* [turns] */
    double ripple_amplitude;                     /* share of the airgap torque */
    double ripple_order;                         /* [1/rad] periods a radian of the joint */
    double ripple_phase;                         /* [turns] */
} Motor;

/* Torque on the joint's side of the gear [N.m]: airgap torque with ripple, and cogging.
 * `angle` [rad] is that of the rotor referred to the joint. */
static inline double motor_torque(const Motor *motor, double psi_d, double psi_q, const double current[2],
                                  double angle) {
    double airgap = 1.5 * motor->pole_pairs * (psi_d * current[1] - psi_q * current[0]);
    double torque = motor->gear_ratio * airgap;
    if (motor->ripple_amplitude != 0.0)
        torque *= 1.0 + motor->ripple_amplitude * sine_of_turns(motor->ripple_order * angle + motor->ripple_phase);
    for (int k = 0; k < COGGING_HARMONICS; ++k)
        if (motor->cogging_amplitude[k] != 0.0)
            torque += motor->cogging_amplitude[k] *
                      sine_of_turns(motor->cogging_order[k] * angle + motor->cogging_phase[k]);
    return torque;
}

/* dpsi/dt = v - R i - w_e J psi [V]: voltages, ohmic drop and rotation. */
static inline void flux_rates(const Motor *motor, double psi_d, double psi_q, const double current[2],
                              double v_d, double v_q, double speed, double rate[2]) {
    double electrical_speed = motor->pole_pairs * motor->gear_ratio * speed;
    rate[0] = v_d - motor->resistance * current[0] + electrical_speed * psi_q;
    rate[1] = v_q - motor->resistance * current[1] - electrical_speed * psi_d;
}

#endif
