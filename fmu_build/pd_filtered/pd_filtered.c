/* u_k = sat(k_p (r_k - y_k) + k_d d_k + k_f f_k), d the filtered difference of c r - y. */
#include "control_laws.h"
#include "variables.h"

typedef struct {
    Derivative derivative;
} ControllerState;

static void control(double *v, ControllerState *state) {
    double reference = v[V_reference];
    double measured = v[V_feedback_from_load] != 0.0 ? v[V_measured_load] : v[V_measured];
    double rate = derivative_next(&state->derivative, v[V_derivative_weight] * reference - measured,
                                  v[V_filter_time], v[V_sample_time]);
    double u = v[V_kp] * (reference - measured) + v[V_kd] * rate + v[V_feedforward_gain] * v[V_feedforward];
    v[V_u] = limited(u, v[V_u_min], v[V_u_max]);
}

#include "sampled_controller.h"
