/* Rotary servo with smooth physics that its user has measured, roughly: gravity, springs, cogging,
 * drag and a constant push. A twin with fifteen uncertain parameters, for `tests/blind/draw`. */
#include "control_laws.h"
#include "model.h"

enum { Q, W, TORQUE, N_STATES };

struct Model {
    double v[N_VARIABLES];
    Sampler sampler;
    double x[N_STATES];
    Derivative rate; /* [rad/s] of the reading */
};
const size_t model_bytes = sizeof(struct Model);

static double reading(const Model *m) { return m->x[Q] + m->v[V_encoder_offset]; }

static void refresh_outputs(Model *m) {
    m->v[V_position] = reading(m);
    m->v[V_true_position] = m->x[Q];
    m->v[V_velocity] = m->x[W];
}

/* tau*_k = sat(kp (r_k - y_k) - kd d_k), d the filtered difference of the reading. */
static void control(Model *m) {
    double *v = m->v, measured = reading(m);
    double rate = derivative_next(&m->rate, measured, v[V_filter_time], v[V_sample_time]);
    v[V_torque_command] =
        limited(v[V_kp] * (v[V_reference] - measured) - v[V_kd] * rate, -v[V_torque_limit], v[V_torque_limit]);
}

static void slope(const double *v, const double *x, double *dx) {
    double q = x[Q], w = x[W], command = v[V_torque_command] + v[V_tau_command];
    double smooth = v[V_push] - v[V_viscous] * w - v[V_drag] * w * fabs(w) - v[V_arm] * sin(q + v[V_arm_phase]) -
                    v[V_spring] * (q - v[V_spring_rest]) - v[V_hardening] * q * q * q +
                    v[V_ripple] * sin(v[V_ripple_cycles] * q + v[V_ripple_phase]);
    dx[Q] = w;
    dx[W] = (x[TORQUE] + v[V_tau_load] + smooth) / v[V_inertia];
    dx[TORQUE] = (v[V_torque_gain] * command - x[TORQUE]) / v[V_torque_lag];
}

/* One classical Runge-Kutta step. */
static void integrate(Model *m, double h) {
    static const double at[] = {0.0, 0.5, 0.5, 1.0}, weight[] = {1.0, 2.0, 2.0, 1.0};
    double k[N_STATES] = {0}, x[N_STATES], sum[N_STATES] = {0};
    for (int stage = 0; stage < 4; ++stage) {
        for (int i = 0; i < N_STATES; ++i) x[i] = m->x[i] + at[stage] * h * k[i];
        slope(m->v, x, k);
        for (int i = 0; i < N_STATES; ++i) sum[i] += weight[stage] * k[i];
    }
    for (int i = 0; i < N_STATES; ++i) m->x[i] += h / 6.0 * sum[i];
}

const char *model_initialise(Model *m, const char *resources) {
    (void)resources;
    m->sampler.period = m->v[V_sample_time];
    m->x[Q] = m->v[V_initial_position];
    refresh_outputs(m);
    return NULL;
}

const char *model_step(Model *m, double t, double h) {
    double end = t + h;
    for (double now = t; now < end;) {
        if (sampler_due(&m->sampler, now)) control(m);
        double until = sampler_until(&m->sampler, end);
        int pieces = (int)fmax(1.0, ceil((until - now) / INTERNAL_STEP - 1e-6));
        for (int i = 0; i < pieces; ++i) integrate(m, (until - now) / pieces);
        now = until;
    }
    refresh_outputs(m);
    return isfinite(m->x[Q]) && isfinite(m->x[W]) ? NULL : "the axis has diverged";
}

const char *model_parameter_changed(Model *m, int index) {
    (void)m, (void)index; /* read again in every step */
    return NULL;
}
