/* The drive below the torque command: current loop, motor, gear, load and encoders. */
#ifndef GMFBO_DRIVE_PLANT_H
#define GMFBO_DRIVE_PLANT_H

#include "current_loop.h"
#include "flux_map_file.h"
#include "mechanics.h"
#include "model.h"
#include "motor.h"
#include "sampling.h"

/* States of the differential equations; angles and speeds at the joint. A rigid drive has no load
 * of its own: its vector ends after the speed of the motor. */
enum { FLUX_D, FLUX_Q, MOTOR_ANGLE, MOTOR_SPEED, LOAD_ANGLE, LOAD_SPEED, FLEXIBLE_STATES };
enum { LOCKED_STATES = MOTOR_ANGLE, RIGID_STATES = LOAD_ANGLE };

/* Longest delay of the drive over its shortest period; model.toml holds both. */
enum { LATE_COMMANDS = 2048 };

typedef struct {
    FluxMap map;
    Motor motor;
    Mechanics mechanics;
    CurrentLoop loop;
    double torque_constant; /* [N.m/A] that the drive assumes, at the joint */
    CurrentLoopState loop_state;
    Sampler sampler;
    double state[FLEXIBLE_STATES];
    double motor_friction, load_friction; /* [N.m] of the bristles, before scaling */
    double load_torque;                   /* [N.m] external, held over a step */
    double commands[LATE_COMMANDS];       /* [N.m] the newest ones, one a period */
    unsigned sampled;                     /* commands so far */
} Plant;

/* ---- parameters ------------------------------------------------------------------------ */

static const double TURN = 6.283185307179586; /* [rad] */

static inline void plant_read_motor(Motor *motor, const double *v) {
    *motor = (Motor){.resistance = v[V_motor_resistance],
                     .pole_pairs = v[V_motor_pole_pairs],
                     .flux = v[V_motor_flux],
                     .gear_ratio = v[V_gear_ratio],
                     .ripple_amplitude = v[V_ripple_amplitude],
                     .ripple_order = v[V_ripple_order] * v[V_motor_pole_pairs] * v[V_gear_ratio] / TURN,
                     .ripple_phase = v[V_ripple_phase] / TURN};
    for (int k = 0; k < COGGING_HARMONICS; ++k) {
        motor->cogging_amplitude[k] = v[V_cogging_amplitude + k];
        motor->cogging_order[k] = v[V_cogging_order + k] * v[V_gear_ratio] / TURN;
        motor->cogging_phase[k] = v[V_cogging_phase + k] / TURN;
    }
}

static inline void plant_read_mechanics(Mechanics *mechanics, const double *v) {
    *mechanics = (Mechanics){
        .flexible = v[V_gear_flexible] != 0.0 || v[V_gear_backlash] > 0.0,
        .motor_inertia = v[V_motor_inertia] * v[V_gear_ratio] * v[V_gear_ratio],
        .load_inertia = v[V_load_inertia],
        .stiffness = v[V_gear_stiffness],
        .damping = v[V_gear_damping],
        .backlash = v[V_gear_backlash],
        .friction_scale = v[V_friction_scale],
        .motor_viscous = v[V_friction_viscous],
        .load_viscous = v[V_load_viscous],
        .motor_friction = {v[V_friction_coulomb], v[V_friction_stribeck], v[V_friction_stribeck_velocity],
                           v[V_friction_presliding]},
        .load_friction = {v[V_load_coulomb], 0.0, v[V_friction_stribeck_velocity],
                          v[V_friction_presliding]},
        .unbalance = v[V_load_unbalance],
        .unbalance_angle = v[V_load_unbalance_angle]};
}

static inline void plant_read_parameters(Plant *plant, const double *v) {
    plant_read_motor(&plant->motor, v);
    plant_read_mechanics(&plant->mechanics, v);
    plant->loop = (CurrentLoop){.resistance = v[V_drive_resistance],
                                .inductance_d = v[V_drive_inductance_d],
                                .inductance_q = v[V_drive_inductance_q],
                                .flux = v[V_drive_flux],
                                .bandwidth = TURN * v[V_drive_bandwidth],
                                .voltage_limit = v[V_drive_voltage] / sqrt(3.0),
                                .period = v[V_drive_sample_time]};
    plant->torque_constant = 1.5 * v[V_motor_pole_pairs] * v[V_gear_ratio] * v[V_drive_flux];
    plant->sampler.period = v[V_drive_sample_time];
}

/* ---- differential equations ------------------------------------------------------------ */

static inline void plant_current(const Plant *plant, const double *state, double current[2]) {
    flux_map_current(&plant->map, state[FLUX_D] - plant->motor.flux, state[FLUX_Q], current);
}

/* Time derivative of the first `n` states; bristles, voltages and the load torque are held. */
static inline void plant_rates(const Plant *plant, int n, const double *x, double *rate) {
    const Mechanics *mechanics = &plant->mechanics;
    double current[2], speed = n > LOCKED_STATES ? x[MOTOR_SPEED] : 0.0;
    plant_current(plant, x, current);
    flux_rates(&plant->motor, x[FLUX_D], x[FLUX_Q], current, plant->loop_state.v_d, plant->loop_state.v_q,
               speed, rate);
    if (n == LOCKED_STATES) return;
    double scale = mechanics->friction_scale;
    double torque = motor_torque(&plant->motor, x[FLUX_D], x[FLUX_Q], current, x[MOTOR_ANGLE]) -
                    scale * (plant->motor_friction + mechanics->motor_viscous * speed);
    int load = n == RIGID_STATES ? MOTOR_ANGLE : LOAD_ANGLE;
    double load_torque = plant->load_torque + unbalance_torque(mechanics, x[load]) -
                         scale * (plant->load_friction + mechanics->load_viscous * x[load + 1]);
    rate[MOTOR_ANGLE] = speed;
    if (n == RIGID_STATES) {
        rate[MOTOR_SPEED] = (torque + load_torque) / (mechanics->motor_inertia + mechanics->load_inertia);
    } else {
        double shaft = shaft_torque(mechanics, x[MOTOR_ANGLE] - x[LOAD_ANGLE], speed - x[LOAD_SPEED]);
        rate[MOTOR_SPEED] = (torque - shaft) / mechanics->motor_inertia;
        rate[LOAD_ANGLE] = x[LOAD_SPEED];
        rate[LOAD_SPEED] = (load_torque + shaft) / mechanics->load_inertia;
    }
}

/* One classical Runge-Kutta step of fourth order for `n` states; n is known where this is called,
 * so that each drive gets loops of fixed length. */
static inline void plant_runge_kutta(Plant *plant, int n, double h) {
    double k1[FLEXIBLE_STATES], k2[FLEXIBLE_STATES], k3[FLEXIBLE_STATES], k4[FLEXIBLE_STATES];
    double at[FLEXIBLE_STATES], *x = plant->state;
    plant_rates(plant, n, x, k1);
    for (int i = 0; i < n; ++i) at[i] = x[i] + 0.5 * h * k1[i];
    plant_rates(plant, n, at, k2);
    for (int i = 0; i < n; ++i) at[i] = x[i] + 0.5 * h * k2[i];
    plant_rates(plant, n, at, k3);
    for (int i = 0; i < n; ++i) at[i] = x[i] + h * k3[i];
    plant_rates(plant, n, at, k4);
    for (int i = 0; i < n; ++i) x[i] += h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
}

static inline double plant_load_angle(const Plant *plant) {
    return plant->state[plant->mechanics.flexible ? LOAD_ANGLE : MOTOR_ANGLE];
}

static inline double plant_load_speed(const Plant *plant) {
    return plant->state[plant->mechanics.flexible ? LOAD_SPEED : MOTOR_SPEED];
}

static inline void plant_deform_bristles(Plant *plant, double duration) {
    const Mechanics *mechanics = &plant->mechanics;
    plant->motor_friction = friction_after(&mechanics->motor_friction, plant->motor_friction,
                                           plant->state[MOTOR_SPEED], duration);
    plant->load_friction = friction_after(&mechanics->load_friction, plant->load_friction,
                                          plant_load_speed(plant), duration);
}

/* Symmetric splitting, second order: half a step of the bristles at the old speed, the rest of
 * the states with the bristles held, half a step at the new speed. */
static inline void plant_integrate(Plant *plant, double duration, int steps) {
    double h = duration / steps;
    for (int k = 0; k < steps; ++k) {
        plant_deform_bristles(plant, 0.5 * h);
        if (plant->mechanics.flexible)
            plant_runge_kutta(plant, FLEXIBLE_STATES, h);
        else
            plant_runge_kutta(plant, RIGID_STATES, h);
        plant_deform_bristles(plant, 0.5 * h);
    }
}

/* ---- drive electronics ----------------------------------------------------------------- */

static inline void plant_control_current(Plant *plant, double torque, double current_limit, double speed) {
    double current[2];
    plant_current(plant, plant->state, current);
    double wanted = fmin(fmax(torque / plant->torque_constant, -current_limit), current_limit);
    double electrical_speed = plant->motor.pole_pairs * plant->motor.gear_ratio * speed;
    current_loop_sample(&plant->loop, &plant->loop_state, -current[0], wanted - current[1], current[0],
                        current[1], electrical_speed);
}

/* Command that acts now: the one of `delay` [s] ago, whole periods; zero torque before the first. */
static inline double plant_late_command(Plant *plant, double torque, double delay) {
    unsigned ago = (unsigned)floor(delay / plant->loop.period + 0.5), now = plant->sampled++;
    plant->commands[now % LATE_COMMANDS] = torque;
    return ago > now ? 0.0 : plant->commands[(now - ago) % LATE_COMMANDS];
}

/* The drive is switched on before the start: 20 ms of the current loop at zero torque, rotor held,
 * so that an altered map does not begin with a kick. */
static inline void plant_energise(Plant *plant, const double *v) {
    int periods = (int)ceil(0.02 / plant->loop.period);
    plant->state[FLUX_D] = plant->motor.flux;
    for (int k = 0; k < periods; ++k) {
        plant_control_current(plant, 0.0, v[V_drive_current_limit], 0.0);
        plant_runge_kutta(plant, LOCKED_STATES, plant->loop.period);
    }
}

/* ---- what the models call -------------------------------------------------------------- */

/* Encoder reading [rad at the joint] of an angle; 0 counts a turn stands for an ideal encoder. */
static inline double encoder_reading(double angle, double counts_per_turn) {
    if (counts_per_turn == 0.0) return angle;
    return floor(angle * counts_per_turn / TURN + 0.5) * (TURN / counts_per_turn);
}

static inline double plant_joint_reading(const Plant *plant, const double *v) {
    return encoder_reading(plant_load_angle(plant), v[V_enc_resolution]);
}

static inline double plant_motor_reading(const Plant *plant, const double *v) {
    return encoder_reading(plant->state[MOTOR_ANGLE], v[V_enc_motor_resolution] * v[V_gear_ratio]);
}

static inline void plant_refresh_outputs(const Plant *plant, double *v) {
    double current[2];
    const double *x = plant->state;
    plant_current(plant, x, current);
    v[V_position] = plant_joint_reading(plant, v);
    v[V_motor_position] = plant_motor_reading(plant, v);
    v[V_true_position] = plant_load_angle(plant);
    v[V_true_motor_position] = x[MOTOR_ANGLE];
    v[V_velocity] = plant_load_speed(plant);
    v[V_motor_velocity] = x[MOTOR_SPEED];
    v[V_torque] = motor_torque(&plant->motor, x[FLUX_D], x[FLUX_Q], current, x[MOTOR_ANGLE]);
    v[V_i_d] = current[0];
    v[V_i_q] = current[1];
    v[V_v_d] = plant->loop_state.v_d;
    v[V_v_q] = plant->loop_state.v_q;
}

static inline const char *plant_initialise(Plant *plant, double *v, const char *resources) {
    const char *fault = flux_map_read(&plant->map, resources);
    if (fault) return fault;
    flux_map_alter(&plant->map, v[V_map_noise], (uint64_t)v[V_map_seed], &v[V_map_delta_d],
                   &v[V_map_delta_q]);
    flux_map_read_out(&plant->map, &v[V_map_node_d], &v[V_map_node_q]);
    plant_read_parameters(plant, v);
    plant_energise(plant, v);
    plant->state[MOTOR_ANGLE] = plant->state[LOAD_ANGLE] = v[V_initial_position];
    plant->state[MOTOR_SPEED] = plant->state[LOAD_SPEED] = v[V_initial_velocity];
    return NULL;
}

/* Advance from t to `end` [s] under the torque command and load torque in v[]. */
static inline const char *plant_advance(Plant *plant, const double *v, double t, double end) {
    double period = plant->loop.period;
    if (v[V_drive_delay] > (LATE_COMMANDS - 1) * period)
        return "drive.delay is longer than 2047 periods of the current loop: shorten it";
    plant->load_torque = v[V_tau_load];
    for (double now = t; now < end;) {
        if (sampler_due(&plant->sampler, now)) {
            double command = v[V_torque_command] + v[V_tau_command_offset];
            plant_control_current(plant, plant_late_command(plant, command, v[V_drive_delay]),
                                  v[V_drive_current_limit], plant->state[MOTOR_SPEED]);
        }
        double until = sampler_until(&plant->sampler, end);
        double duration = until - now;
        /* A whole period has always the same length, however t was rounded. */
        if (fabs(duration - period) <= 2.0 * sampler_tolerance(&plant->sampler, end)) duration = period;
        plant_integrate(plant, duration, (int)ceil(duration / period * v[V_solver_substeps] - 1e-6));
        now = until;
    }
    const double *x = plant->state;
    return isfinite(x[FLUX_D] + x[FLUX_Q] + plant_load_angle(plant) + plant_load_speed(plant))
               ? NULL
               : "the drive has diverged";
}

#endif
