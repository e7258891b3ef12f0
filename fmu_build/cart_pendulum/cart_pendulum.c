/* Inverted pendulum on a cart (a bob on a rod without mass) under sampled state feedback:
 * F*_k = sat(kx (x_k - r_k) + kv v_k + ka a_k + kw w_k), velocities as filtered differences of the
 * readings. Forces are positive along the cart: to fetch the pendulum back, all gains are. */
#include "control_laws.h"
#include "model.h"

enum { X, V, A, W, N_STATES };
static const double GRAVITY = 9.80665; /* [m/s2] */
static const double PI = 3.14159265358979323846;

struct Model {
    double v[N_VARIABLES];
    Sampler sampler;
    double x[N_STATES];
    Derivative speed, spin; /* [m/s], [rad/s] of the readings */
};
const size_t model_bytes = sizeof(struct Model);

static double reading(const Model *m) { return m->x[X] + m->v[V_port_sensor]; }

static void refresh_outputs(Model *m) {
    m->v[V_position] = reading(m);
    m->v[V_true_position] = m->x[X];
    m->v[V_velocity] = m->x[V];
    m->v[V_angle] = m->x[A];
}

static void control(Model *m) {
    double *v = m->v, measured = reading(m);
    double speed = derivative_next(&m->speed, measured, v[V_filter_time], v[V_sample_time]);
    double spin = derivative_next(&m->spin, m->x[A], v[V_filter_time], v[V_sample_time]);
    double wanted = v[V_kx] * (measured - v[V_reference]) + v[V_kv] * speed + v[V_ka] * m->x[A] + v[V_kw] * spin;
    v[V_force_command] = limited(wanted, -v[V_force_limit], v[V_force_limit]);
}

/* Lagrange's equations, solved for both accelerations. */
static void slope_at(const Model *m, const double *x, double *slope) {
    const double *v = m->v;
    double bob = v[V_bob_mass], length = v[V_length], s = sin(x[A]), c = cos(x[A]);
    double force = v[V_force_command] + v[V_port_command] + v[V_port_force] - v[V_viscous] * x[V];
    double pivot = v[V_pivot_viscous] * x[W] / length;
    double whole = v[V_cart_mass] + bob * s * s;
    slope[X] = x[V];
    slope[V] = (force + bob * length * s * x[W] * x[W] - bob * GRAVITY * s * c + pivot * c) / whole;
    slope[A] = x[W];
    slope[W] = (GRAVITY * s - slope[V] * c - pivot / bob) / length;
}

static void runge_kutta(Model *m, double h) {
    static const double share[4] = {0.0, 0.5, 0.5, 1.0}, weight[4] = {1.0, 2.0, 2.0, 1.0};
    double slope[N_STATES] = {0.0}, sum[N_STATES] = {0.0};
    for (int stage = 0; stage < 4; ++stage) {
        double at[N_STATES];
        for (int i = 0; i < N_STATES; ++i) at[i] = m->x[i] + share[stage] * h * slope[i];
        slope_at(m, at, slope);
        for (int i = 0; i < N_STATES; ++i) sum[i] += weight[stage] * slope[i];
    }
    for (int i = 0; i < N_STATES; ++i) m->x[i] += h / 6.0 * sum[i];
}

const char *model_initialise(Model *m, const char *resources) {
    (void)resources;
    m->sampler.period = m->v[V_sample_time];
    refresh_outputs(m);
    return NULL;
}

const char *model_step(Model *m, double t, double h) {
    double end = t + h;
    for (double now = t; now < end;) {
        if (sampler_due(&m->sampler, now)) control(m);
        double until = sampler_until(&m->sampler, end);
        double pieces = fmax(1.0, ceil((until - now) / INTERNAL_STEP - 1e-6)), piece = (until - now) / pieces;
        for (double k = 0.0; k < pieces; k += 1.0) runge_kutta(m, piece);
        now = until;
    }
    refresh_outputs(m);
    /* A rod that lies on the track has fallen: nothing fetches it back. */
    return fabs(m->x[A]) < 0.5 * PI ? NULL : "the pendulum has fallen";
}

const char *model_parameter_changed(Model *m, int index) {
    (void)m, (void)index; /* read again in every step */
    return NULL;
}
