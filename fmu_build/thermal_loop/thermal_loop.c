/* Heated body with one heat capacity, loss to its surroundings, and a heater whose power arrives
 * after a dead time. The power is held between steps, so that each piece is exact. */
#include "model.h"

#include <math.h>

enum { QUEUE = 8192 }; /* powers under way: 4,096 s of dead time at steps of 0.5 s */

struct Model {
    double v[N_VARIABLES];
    double temperature;
    double arrived; /* [W] */
    double due[QUEUE], waiting[QUEUE];
    long head, tail;
};
const size_t model_bytes = sizeof(struct Model);

static void refresh_outputs(Model *m) {
    m->v[V_temperature] = m->temperature + m->v[V_sensor_offset];
    m->v[V_true_temperature] = m->temperature;
    m->v[V_arrived_power] = m->arrived;
}

const char *model_initialise(Model *m, const char *resources) {
    (void)resources;
    m->temperature = m->v[V_initial_temperature];
    refresh_outputs(m);
    return NULL;
}

/* C dT/dt = P - k (T - T_ambient), over a duration with constant power. */
static void advance(Model *m, double duration) {
    const double *v = m->v;
    double heat = m->arrived + v[V_heat_load];
    double rate = v[V_loss] / v[V_capacity];
    double gap = m->temperature - v[V_ambient];
    double decay = -expm1(-rate * duration);
    double share = rate > 0.0 ? decay / rate : duration;
    m->temperature += share * heat / v[V_capacity] - decay * gap;
}

const char *model_step(Model *m, double t, double h) {
    double end = t + h, slack = 1e-9 * h;
    if (m->tail - m->head >= QUEUE) return "the dead time is longer than 8192 steps: take larger ones";
    m->due[m->tail % QUEUE] = t + m->v[V_dead_time];
    m->waiting[m->tail++ % QUEUE] = m->v[V_power];
    for (double now = t; now < end - slack;) {
        while (m->head < m->tail && m->due[m->head % QUEUE] <= now + slack)
            m->arrived = m->waiting[m->head++ % QUEUE];
        double until = m->head < m->tail ? fmin(end, m->due[m->head % QUEUE]) : end;
        advance(m, until - now);
        now = until;
    }
    refresh_outputs(m);
    return isfinite(m->temperature) ? NULL : "the temperature has diverged";
}

const char *model_parameter_changed(Model *m, int index) {
    (void)m, (void)index; /* read again in every step */
    return NULL;
}
