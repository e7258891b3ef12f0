/* Sensor port: what is added to the true reading. */
#ifndef GMFBO_PHYSICS_SENSOR_H
#define GMFBO_PHYSICS_SENSOR_H

#include "harmonics.h"

typedef struct {
    int running;
    double delayed;  /* output of the lag at the last communication point */
    double position; /* its input there */
} SensorLag;

static inline double sensor_offset(const double *v) { return v[V_sensor_offset_level]; }

static inline double sensor_scale(const double *v, const Signals *s) {
    return v[V_sensor_scale_share] * s->position;
}

typedef struct {
    int done;
    double position; /* where the axis stood */
} Homing;

static inline double eccentricity_at(const double *v, double position) {
    return harmonic(v[V_sensor_eccentricity_sine], v[V_sensor_eccentricity_cosine],
                    v[V_sensor_eccentricity_wavenumber] * position);
}

/* Homing set the reading right where the axis stood: the error counts from there. */
static inline double sensor_eccentricity(Homing *homing, const double *v, const Signals *s) {
    if (!homing->done) *homing = (Homing){1, s->position};
    return eccentricity_at(v, s->position) - eccentricity_at(v, homing->position);
}

/* Lagged reading minus the reading, exact where the position is a straight line between points:
 * behind a ramp the lag is slope * time, and what is left of other starts decays. */
static inline double sensor_lag(SensorLag *lag, const double *v, const Signals *s, double last_step) {
    double time = v[V_sensor_lag_time];
    if (time == 0.0) return lag->running = 0, 0.0;
    if (!lag->running) *lag = (SensorLag){1, s->position, s->position};
    if (last_step > 0.0) {
        double behind = rate_of_change(s->position, lag->position, last_step) * time;
        double excess = lag->delayed - lag->position + behind;
        lag->delayed = s->position - behind + excess * exp(-last_step / time);
    }
    lag->position = s->position;
    return lag->delayed - s->position;
}

#endif
