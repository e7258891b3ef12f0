/* u_k = sat(k_p (b r_k - y_k) + I_k + k_d d_k + k_f f_k), d the filtered difference of c r - y;
 * the integral of k_i (r - y) gives way while u is limited. */
#include "control_laws.h"
#include "variables.h"

typedef struct {
    Derivative derivative;
    double integral;
} ControllerState;

static void control(double *v, ControllerState *state) {
    double reference = v[V_reference];
    double measured = v[V_feedback_from_load] != 0.0 ? v[V_measured_load] : v[V_measured];
    double rate = derivative_next(&state->derivative, v[V_derivative_weight] * reference - measured,
                                  v[V_filter_time], v[V_sample_time]);
    double raw = v[V_kp] * (v[V_proportional_weight] * reference - measured) + state->integral + v[V_kd] * rate +
                 v[V_feedforward_gain] * v[V_feedforward];
    v[V_u] = limited(raw, v[V_u_min], v[V_u_max]);
    state->integral = integral_next(state->integral, v[V_ki] * (reference - measured), raw - v[V_u],
                                v[V_anti_windup_gain], v[V_sample_time]);
}

#include "sampled_controller.h"
