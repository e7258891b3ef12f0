/* Linear servo axis (EMPS; Janot, Gautier, Brunot 2019): the plant translated from
 * LinearAxis.mo, its integrator, and the sampled controller. */
#include <math.h>

#include "LinearAxis.h"
#include "model.h"
#include "sampling.h"

struct Model {
    double v[N_VARIABLES];
    Sampler sampler;
    double y[N_STATE];
    double p[N_PARAMETER];       /* parameters and inputs of the plant, as they act now */
    double reading_1, reading_2; /* [m] encoder one and two samples ago */
};
const size_t model_bytes = sizeof(struct Model);

static double reading(const Model *m) { return m->y[STATE_position] + m->v[V_port_sensor]; }

static void apply_to_plant(Model *m) {
    const double *v = m->v;
    m->p[PARAMETER_mass] = v[V_mass];
    m->p[PARAMETER_viscous_friction] = v[V_viscous_friction];
    m->p[PARAMETER_force_gain] = v[V_force_gain];
    m->p[PARAMETER_voltage] = v[V_drive_voltage] + v[V_port_command];
    m->p[PARAMETER_port_force] = v[V_port_force];
}

static void refresh_outputs(Model *m, double t) {
    double workspace[N_WORKSPACE], observed[N_OBSERVED];
    observe(t, m->y, m->p, workspace, observed);
    m->v[V_true_position] = observed[OBSERVED_position];
    m->v[V_velocity] = observed[OBSERVED_velocity];
    m->v[V_force] = observed[OBSERVED_force];
    m->v[V_position] = reading(m);
}

/* vir = kv (kp (qg - qm) - dqf), where dqf is the difference of the mean of two readings. */
static void control(Model *m) {
    double *v = m->v;
    double measured = reading(m);
    double rate = (measured - m->reading_2) / (2.0 * v[V_sample_time]);
    double command = v[V_kv] * (v[V_kp] * (v[V_reference] - measured) - rate);
    v[V_drive_voltage] = fmin(fmax(command, -v[V_voltage_limit]), v[V_voltage_limit]);
    m->reading_2 = m->reading_1;
    m->reading_1 = measured;
}

/* dy = slope at y + h * slope_before; one stage of a Runge-Kutta step. */
static void stage(const Model *m, double t, double h, const double *before, double *slope) {
    double y[N_STATE], workspace[N_WORKSPACE];
    for (int i = 0; i < N_STATE; ++i) y[i] = m->y[i] + h * before[i];
    rhs(t + h, y, m->p, workspace, slope);
}

/* Classical Runge-Kutta steps of fourth order, the duration divided evenly. */
static void integrate(Model *m, double t, double duration) {
    static const double none[N_STATE];
    int steps = (int)fmax(1.0, ceil(duration / INTERNAL_STEP - 1e-6));
    double h = duration / steps;
    for (int i = 0; i < steps; ++i) {
        double k1[N_STATE], k2[N_STATE], k3[N_STATE], k4[N_STATE], now = t + i * h;
        stage(m, now, 0.0, none, k1);
        stage(m, now, 0.5 * h, k1, k2);
        stage(m, now, 0.5 * h, k2, k3);
        stage(m, now, h, k3, k4);
        for (int j = 0; j < N_STATE; ++j) m->y[j] += h / 6.0 * (k1[j] + 2.0 * k2[j] + 2.0 * k3[j] + k4[j]);
    }
}

const char *model_initialise(Model *m, const char *resources) {
    (void)resources;
    m->sampler.period = m->v[V_sample_time];
    m->y[STATE_position] = m->v[V_initial_position];
    m->reading_1 = m->reading_2 = reading(m);
    apply_to_plant(m);
    refresh_outputs(m, 0.0);
    return NULL;
}

const char *model_step(Model *m, double t, double h) {
    double end = t + h;
    for (double now = t; now < end;) {
        if (sampler_due(&m->sampler, now)) control(m);
        apply_to_plant(m);
        double until = sampler_until(&m->sampler, end);
        integrate(m, now, until - now);
        now = until;
    }
    refresh_outputs(m, end);
    return isfinite(m->y[STATE_position]) && isfinite(m->y[STATE_velocity]) ? NULL : "the axis has diverged";
}

const char *model_parameter_changed(Model *m, int index) {
    (void)m, (void)index; /* read again in every step */
    return NULL;
}
