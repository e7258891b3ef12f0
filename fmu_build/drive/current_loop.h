/* Field-oriented current control at a fixed rate: PI with decoupling and a voltage limit. */
#ifndef GMFBO_DRIVE_CURRENT_LOOP_H
#define GMFBO_DRIVE_CURRENT_LOOP_H

#include <math.h>

/* What the drive has been told of its motor; the motor itself may differ. */
typedef struct {
    double resistance;               /* [Ohm] */
    double inductance_d, inductance_q; /* [H] */
    double flux;                     /* [Wb] of the magnets */
    double bandwidth;                /* [rad/s] of the closed loop */
    double voltage_limit;            /* [V] amplitude of the phase voltage */
    double period;                   /* [s] */
} CurrentLoop;

typedef struct {
    double integral_d, integral_q; /* [V] */
    double v_d, v_q;               /* [V] held until the next sample */
} CurrentLoopState;

/* One sample. Each axis is R + s L, so gains w L and w R make the closed loop w / (s + w). The
 * integrals take up only what the limited voltage left of the error (back calculation). */
static inline void current_loop_sample(const CurrentLoop *loop, CurrentLoopState *state, double error_d,
                                       double error_q, double i_d, double i_q, double electrical_speed) {
    double gain_d = loop->bandwidth * loop->inductance_d, gain_q = loop->bandwidth * loop->inductance_q;
    double forward_d = -electrical_speed * loop->inductance_q * i_q;
    double forward_q = electrical_speed * (loop->inductance_d * i_d + loop->flux);
    double wanted_d = gain_d * error_d + state->integral_d + forward_d;
    double wanted_q = gain_q * error_q + state->integral_q + forward_q;
    double amplitude = sqrt(wanted_d * wanted_d + wanted_q * wanted_q);
    double share = amplitude > loop->voltage_limit ? loop->voltage_limit / amplitude : 1.0;
    state->v_d = share * wanted_d;
    state->v_q = share * wanted_q;
    double rate = loop->bandwidth * loop->resistance * loop->period;
    state->integral_d += rate * (error_d + (state->v_d - wanted_d) / gain_d);
    state->integral_q += rate * (error_q + (state->v_q - wanted_q) / gain_q);
}

#endif
