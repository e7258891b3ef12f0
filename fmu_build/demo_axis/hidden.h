/* Physics that the rigid servo axis leaves out; each part is absent where its size is zero.
 *
 * Written apart from fmu_build/physics, by other laws and another integrator, so that what is found
 * in recordings of this plant is not found by its own model: friction is hard (a surface sticks while
 * the torque on it is within the breakaway level), gaps close on Hunt and Crossley's contact, and
 * the delayed command arrives off the grid. */
#ifndef GMFBO_DEMO_AXIS_HIDDEN_H
#define GMFBO_DEMO_AXIS_HIDDEN_H

#include <math.h>
#include <string.h>

#define TWO_PI 6.283185307179586

/* [rad], [rad/s] of the motor and of the load; [N.m] command behind the drive's lag, and torque. */
enum { Q, W, LOAD_Q, LOAD_W, LAGGED, TORQUE, N_STATES };

typedef struct {
    double inertia, viscous, torque_lag;                        /* the axis as its twin has it */
    double friction_forward, friction_backward, breakaway, stribeck_velocity;
    double drag;
    double load_inertia, shaft_stiffness, shaft_damping;
    double gap, contact_stiffness, contact_damping;
    double ripple, ripple_cycles, ripple_phase;
    double arm, arm_angle, spring, spring_rest, push;
    double hum, hum_frequency, hum_phase;
    double dead_zone, limit, lag;
} Hidden;

static inline double clipped(double x, double most) { return fmin(fmax(x, -most), most); }

static inline int has_friction(const Hidden *p) {
    return p->friction_forward + p->friction_backward + p->breakaway > 0.0;
}

/* Level that holds the surface, or slows it down at a speed (Stribeck 1902). */
static inline double friction_level(const Hidden *p, double velocity, int direction) {
    double level = direction > 0 ? p->friction_forward : p->friction_backward;
    double s = p->stribeck_velocity > 0.0 ? velocity / p->stribeck_velocity : 0.0;
    return level + p->breakaway * exp(-s * s);
}

/* Command as the drive passes it on at once. */
static inline double drive(const Hidden *p, double command) {
    double passed = command - clipped(command, p->dead_zone);
    return p->limit > 0.0 ? clipped(passed, p->limit) : passed;
}

/* Torque of the motor on the load: an elastic belt, or contact at either side of a gap (Hunt and
 * Crossley 1975: k d^1.5 (1 + c d'), never pulling). */
static inline double transmitted(const Hidden *p, const double *x) {
    if (p->load_inertia <= 0.0) return 0.0;
    double twist = x[Q] - x[LOAD_Q], rate = x[W] - x[LOAD_W];
    if (p->gap <= 0.0) return p->shaft_stiffness * twist + p->shaft_damping * rate;
    double side = twist < 0.0 ? -1.0 : 1.0, depth = fabs(twist) - 0.5 * p->gap;
    if (depth <= 0.0) return 0.0;
    return side * fmax(0.0, p->contact_stiffness * pow(depth, 1.5) * (1.0 + p->contact_damping * side * rate));
}

/* All torques on the motor but hard friction. */
static inline double applied(const Hidden *p, double t, const double *x) {
    double q = x[Q], w = x[W];
    return x[TORQUE] - p->viscous * w - p->drag * w * fabs(w) - transmitted(p, x) +
           p->ripple * sin(p->ripple_cycles * q + p->ripple_phase) - p->arm * sin(q - p->arm_angle) -
           p->spring * (q - p->spring_rest) + p->push + p->hum * sin(TWO_PI * p->hum_frequency * t + p->hum_phase);
}

#endif
