/* Position P over velocity PI: w*_k = sat(k_p (r_k - y_k) + k_w f_k), e_k = w*_k - w_k with w the
 * filtered difference of the position, u_k = sat(k_v e_k + I_k + k_f f_k); the integral of k_i e
 * gives way while u is limited. */
#include "control_laws.h"
#include "variables.h"

typedef struct {
    Derivative velocity;
    double integral;
} ControllerState;

static void control(double *v, ControllerState *state) {
    double for_position = v[V_position_from_load] != 0.0 ? v[V_measured_load] : v[V_measured];
    double for_velocity = v[V_velocity_from_load] != 0.0 ? v[V_measured_load] : v[V_measured];
    double velocity = derivative_next(&state->velocity, for_velocity, v[V_filter_time], v[V_sample_time]);
    double wanted = v[V_kp] * (v[V_reference] - for_position) + v[V_velocity_feedforward_gain] * v[V_feedforward];
    v[V_velocity_reference] = limited(wanted, -v[V_velocity_limit], v[V_velocity_limit]);
    double error = v[V_velocity_reference] - velocity;
    double raw = v[V_kv] * error + state->integral + v[V_feedforward_gain] * v[V_feedforward];
    v[V_u] = limited(raw, v[V_u_min], v[V_u_max]);
    state->integral = integral_next(state->integral, v[V_ki] * error, raw - v[V_u], v[V_anti_windup_gain],
                                v[V_sample_time]);
}

#include "sampled_controller.h"
