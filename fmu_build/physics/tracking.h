/* What holds a twin on a recorded position, to read off what it lacks. */
#ifndef GMFBO_PHYSICS_TRACKING_H
#define GMFBO_PHYSICS_TRACKING_H

#include "signals.h"

typedef struct {
    double error; /* of the position at the last communication point */
} Tracking;

/* Torque of a virtual spring and damper between the twin and the recording. */
static inline double tracking_effort(Tracking *tracking, const double *v, const Signals *s, double last_step) {
    double error = v[V_tracking_measured] - s->position;
    double rate = rate_of_change(error, tracking->error, last_step);
    tracking->error = error;
    if (v[V_tracking_kp] == 0.0 && v[V_tracking_kd] == 0.0) return 0.0;
    return v[V_tracking_kp] * error + v[V_tracking_kd] * rate;
}

/* What makes the twin read the recording, whose sensor's errors are in it already. */
static inline double tracking_reading(const double *v, const Signals *s) {
    return v[V_tracking_measured] - s->position;
}

#endif
