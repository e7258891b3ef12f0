/* Sampled position, velocity and torque (JPVT) controller, outermost loop of the drive. */
#ifndef GMFBO_DRIVE_POSITION_CONTROLLER_H
#define GMFBO_DRIVE_POSITION_CONTROLLER_H

#include <math.h>

#include "model.h"
#include "sampling.h"

enum { LONGEST_DELAY = 32 }; /* samples; the maximum of ctl.delay in model.toml */

typedef struct {
    Sampler sampler;
    int started;
    double last_motor;              /* [rad] motor encoder one sample ago */
    double velocity;                /* [rad/s] filtered difference of the motor encoder */
    double commands[LONGEST_DELAY + 1]; /* [N.m] ring, newest at `newest` */
    int newest;
} PositionController;

static inline void position_controller_initialise(PositionController *controller, const double *v) {
    controller->sampler.period = v[V_ctl_sample_time];
}

/* Velocity [rad/s] of the joint: the finer motor encoder differenced, then a first-order low pass
 * that is exact for held inputs. */
static inline double estimate_velocity(PositionController *controller, const double *v, double motor) {
    double period = v[V_ctl_sample_time], constant = v[V_ctl_velocity_filter];
    if (!controller->started) controller->last_motor = motor;
    controller->started = 1;
    double difference = (motor - controller->last_motor) / period;
    double share = constant > 0.0 ? -expm1(-period / constant) : 1.0;
    controller->last_motor = motor;
    return controller->velocity += share * (difference - controller->velocity);
}

/* One sample of tau* = Kp (q* - q) + Kd (w* - dq/dt) + tau_ff, limited, `ctl.delay` samples later
 * at the drive; sets v[torque_command]. Encoder readings [rad] are referred to the joint. */
static inline void position_controller_sample(PositionController *controller, double *v, double joint,
                                              double motor) {
    joint += v[V_encoder_offset];
    motor += v[V_encoder_offset] + v[V_motor_encoder_offset];
    double velocity = estimate_velocity(controller, v, motor);
    double command = v[V_ctl_Kp] * (v[V_reference] - joint) +
                     v[V_ctl_Kd] * (v[V_velocity_reference] - velocity) + v[V_torque_reference];
    double limit = v[V_ctl_torque_limit];
    int slots = LONGEST_DELAY + 1;
    controller->newest = (controller->newest + 1) % slots;
    controller->commands[controller->newest] = fmin(fmax(command, -limit), limit);
    int due = controller->newest - (int)v[V_ctl_delay] + slots;
    v[V_torque_command] = controller->commands[due % slots];
}

#endif
