/* What an effect may depend on: the twin's outputs at the communication point, held over a step. */
#ifndef GMFBO_PHYSICS_SIGNALS_H
#define GMFBO_PHYSICS_SIGNALS_H

#include <math.h>

#include "model.h"

/* Units are those of the twin. */
typedef struct {
    double time, step;    /* [s] start and length of the step */
    double position;      /* true reading: without what the sensor port adds */
    double velocity;
    double acceleration;  /* difference of the velocity over the last step */
    double command;       /* as the twin's controller gives it */
    double current;       /* the command where no current is known */
    double load_torque;   /* the current where no load torque is known */
    double voltage, load_position, temperature;
} Signals;

/* What differences need of the step before. */
typedef struct {
    double step; /* [s]; 0 before the first step */
    double position, velocity;
} LastStep;

/* Whether this setting of 0 or 1 is chosen. */
static inline int chosen(double setting) { return setting > 0.5; }

static inline double rate_of_change(double now, double before, double step) {
    return step > 0.0 ? (now - before) / step : 0.0;
}

/* The reading of a twin that feels the sensor port holds the port's value of the last step. */
static inline Signals signals_now(const double *v, const LastStep *last, double t, double h) {
    Signals s = {.time = t, .step = h};
    s.position = v[V_state_position] - (chosen(v[V_tracking_sensor_included]) ? v[V_sensor] : 0.0);
    s.velocity = chosen(v[V_settings_velocity_from_position])
                     ? rate_of_change(s.position, last->position, last->step)
                     : v[V_state_velocity];
    s.acceleration = rate_of_change(s.velocity, last->velocity, last->step);
    s.command = v[V_settings_command_is_input] > 0.5 ? v[V_port_command] : v[V_state_command];
    s.current = chosen(v[V_settings_current_known]) ? v[V_state_current] : s.command;
    s.load_torque = chosen(v[V_settings_load_torque_known]) ? v[V_state_load_torque] : s.current;
    s.voltage = v[V_state_voltage];
    s.load_position = v[V_state_load_position];
    s.temperature = v[V_state_temperature];
    return s;
}

static inline LastStep last_step(const Signals *s) {
    return (LastStep){.step = s->step, .position = s->position, .velocity = s->velocity};
}

#endif
