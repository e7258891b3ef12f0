/* The real axis of the demo: a servo with the controller that its twin knows, and physics that its
 * twin may lack. */
#include "random.h"
#include "control_laws.h"
#include "integration.h"
#include "model.h"

enum { MOST_WAITING = 128 };

struct Model {
    double v[N_VARIABLES];
    Sampler sampler;
    Axis axis;
    Derivative rate;                                    /* [rad/s] of the reading */
    double waiting[MOST_WAITING], arrival[MOST_WAITING]; /* commands under way to the drive */
    int first, count;
};
const size_t model_bytes = sizeof(struct Model);

static Hidden hidden(const double *v) {
    return (Hidden){
        .inertia = v[V_inertia], .viscous = v[V_viscous], .torque_lag = v[V_torque_lag],
        .friction_forward = v[V_friction_forward], .friction_backward = v[V_friction_backward],
        .breakaway = v[V_friction_breakaway], .stribeck_velocity = v[V_friction_stribeck_velocity],
        .drag = v[V_drag],
        .load_inertia = v[V_load_inertia], .shaft_stiffness = v[V_belt_stiffness], .shaft_damping = v[V_belt_damping],
        .gap = v[V_gap], .contact_stiffness = v[V_contact_stiffness], .contact_damping = v[V_contact_damping],
        .ripple = v[V_ripple_torque], .ripple_cycles = v[V_ripple_cycles], .ripple_phase = v[V_ripple_phase],
        .arm = v[V_arm_torque], .arm_angle = v[V_arm_angle],
        .spring = v[V_spring_stiffness], .spring_rest = v[V_spring_rest], .push = v[V_push],
        .hum = v[V_hum_torque], .hum_frequency = v[V_hum_frequency], .hum_phase = v[V_hum_phase],
        .dead_zone = v[V_drive_dead_zone], .limit = v[V_drive_limit], .lag = v[V_drive_lag],
    };
}

/* Counted position, with noise that belongs to its sample: read twice, it is the same. */
static double reading(const Model *m, double t) {
    const double *v = m->v;
    uint64_t state = ((uint64_t)v[V_encoder_seed] << 32) ^ (uint64_t)llround(t / v[V_sample_time]);
    uint64_t drawn = random_bits(&state);
    double noisy = m->axis.x[Q] + v[V_encoder_noise] * random_normal(&drawn);
    double count = TWO_PI / v[V_encoder_counts];
    return v[V_encoder_counts] > 0.0 ? count * floor(noisy / count + 0.5) : noisy;
}

static void refresh_outputs(Model *m, double t) {
    m->v[V_position] = reading(m, t);
    m->v[V_true_position] = m->axis.x[Q];
    m->v[V_velocity] = m->axis.x[W];
    m->v[V_torque] = m->axis.x[TORQUE];
}

/* tau*_k = sat(kp (r_k - y_k) - kd d_k), d the filtered difference of the reading. */
static void control(Model *m, double t) {
    double *v = m->v, measured = reading(m, t);
    double rate = derivative_next(&m->rate, measured, v[V_filter_time], v[V_sample_time]);
    v[V_torque_command] =
        limited(v[V_kp] * (v[V_reference] - measured) - v[V_kd] * rate, -v[V_torque_limit], v[V_torque_limit]);
    int last = (m->first + m->count++) % MOST_WAITING;
    m->waiting[last] = v[V_torque_command];
    m->arrival[last] = t + v[V_drive_delay];
}

static const char *check(const Model *m) {
    const double *v = m->v;
    if (v[V_load_inertia] >= v[V_inertia])
        return "'load.inertia' is part of 'inertia': expected less than the whole";
    if (v[V_drive_delay] > (MOST_WAITING - 2) * v[V_sample_time])
        return "'drive.delay' is longer than 126 samples: shorten it";
    if (v[V_drive_lag] > 0.0 && v[V_drive_lag] < INNER_STEP)
        return "'drive.lag' is shorter than the inner step: expected 0, or at least 2e-5 s";
    return NULL;
}

const char *model_initialise(Model *m, const char *resources) {
    (void)resources;
    m->sampler.period = m->v[V_sample_time];
    m->axis.x[Q] = m->axis.x[LOAD_Q] = m->v[V_initial_position];
    refresh_outputs(m, 0.0);
    return check(m);
}

/* Up to `until`, cut where a command arrives at the drive. */
static void advance(Model *m, const Hidden *p, double now, double until) {
    while (now < until) {
        while (m->count && m->arrival[m->first] <= now + 1e-12) {
            m->axis.command = m->waiting[m->first];
            m->first = (m->first + 1) % MOST_WAITING;
            --m->count;
        }
        double cut = m->count && m->arrival[m->first] < until - 1e-12 ? m->arrival[m->first] : until;
        axis_advance(&m->axis, p, now, cut - now);
        now = cut;
    }
}

const char *model_step(Model *m, double t, double h) {
    Hidden p = hidden(m->v);
    double end = t + h;
    for (double now = t; now < end;) {
        if (sampler_due(&m->sampler, now)) control(m, now);
        double until = sampler_until(&m->sampler, end);
        advance(m, &p, now, until);
        now = until;
    }
    refresh_outputs(m, end);
    return isfinite(m->axis.x[Q]) && isfinite(m->axis.x[W]) ? NULL : "the axis has diverged";
}

const char *model_parameter_changed(Model *m, int index) {
    (void)index; /* read again in every step */
    return check(m);
}
