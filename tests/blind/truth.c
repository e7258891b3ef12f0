/* The plants of the blind benchmark: one or two masses, a drive, a sensor and sampled controllers.
 *
 * Written apart from the package that is tested, and integrated otherwise: classical Runge-Kutta
 * steps of 20 us, cut where a delayed command arrives and where a velocity crosses zero. Friction
 * is hard: a surface sticks while the torque on it is within the breakaway level, and slips else.
 * Positions, torques and commands are in any consistent units; times are in seconds. */
#include <math.h>
#include <string.h>

#if defined(_WIN32)
#define VISIBLE __declspec(dllexport)
#else
#define VISIBLE __attribute__((visibility("default")))
#endif

/* name: meaning; every size that is zero is absent unless said otherwise */
#define PARAMETERS(X)                                                                                     \
    X(inertia) X(viscous) X(torque_gain) X(torque_lag) /* drive: torque_gain per unit of command */       \
    X(kind) X(kp) X(kd) X(ki) X(kv) X(filter_time) X(derivative_weight) X(anti_windup) X(u_limit)         \
    X(friction_positive) X(friction_negative) X(friction_breakaway) X(friction_speed) X(friction_shape)   \
    X(friction_torque_share) X(friction_wave) X(friction_wave_number) X(friction_wave_phase)              \
    X(friction_wave_one_way)                                                                              \
    X(bristle_level) X(bristle_stiffness) X(bristle_damping)                                              \
    X(slip_force) X(slip_length)             /* Maxwell slip: force of all elements, travel of the last */ \
    X(drag) X(root_friction) X(position_times_velocity) X(load_inertia_extra)                             \
    X(load_inertia) X(shaft_stiffness) X(shaft_damping) X(gap) X(contact_exponent) X(contact_damping)     \
    X(wave_number_1) X(wave_1) X(wave_phase_1) X(wave_number_2) X(wave_2) X(wave_phase_2)                 \
    X(wave_number_3) X(wave_3) X(wave_phase_3)                                                            \
    X(ripple_number) X(ripple) X(ripple_phase)                                                            \
    X(pendulum) X(pendulum_phase) X(spring) X(spring_rest) X(spring_dead_band) X(push)                    \
    X(hum_frequency) X(hum) X(hum_phase) X(pulse_start) X(pulse_duration) X(pulse)                        \
    X(drive_gain_error) X(iron_level) X(heat_loss) X(heat_time) X(heat_scale) X(dead_width)               \
    X(drive_limit) X(supply_limit) X(supply_slope) X(drive_rate) X(drive_lag) X(delay)                    \
    X(sensor_time) X(sensor_eccentricity) X(sensor_phase) X(sensor_scale) X(sensor_zero) X(quantum)       \
    X(cubic_spring) X(friction_growth) X(uneven) X(coarse) X(bend) X(line_error) X(line_number) X(play)   \
    X(start) X(sample) /* [s] period of the controller and of a row; 0 is a millisecond */                  \
    X(cubic_drag) X(rippled_drag) X(rippled_drag_number) X(drive_play)                                    \
    X(sweep) X(sweep_frequency) X(sweep_rate) X(sweep_phase)

typedef struct {
#define FIELD(name) double name;
    PARAMETERS(FIELD)
#undef FIELD
} Parameters;

static const char *const names[] = {
#define NAME(name) #name,
    PARAMETERS(NAME)
#undef NAME
};

enum { N_PARAMETERS = sizeof names / sizeof *names, ELEMENTS = 5, QUEUE = 256 };
enum { Q, V, TORQUE, DRIVE, LOAD_Q, LOAD_V, BRISTLE, HEAT, SENSED, N_STATES };
enum { SERVO_PD = 1, AXIS_PV, PID, CASCADE, PD };
enum { READING, HELD, NEW, POSITION, VELOCITY, ACTIVE, COLUMNS };

static const double MILLISECOND = 1e-3, INNER = 2e-5, PI = 3.14159265358979323846;

typedef struct {
    Parameters p;
    double x[N_STATES];
    double arrived;  /* command that has reached the drive */
    double followed; /* the same behind the limit of its rate */
    double element[ELEMENTS];
    double q_of_elements; /* position at which `element` was last updated */
    int stuck, direction; /* of the surface; direction of slip, 0 where there is no friction */
    double due[QUEUE], waiting[QUEUE];
    long head, tail;
    double followed_by_sensor; /* position behind the play of its coupling */
    double load; /* torque of this sample that is no part of the plant */
    double active; /* time of this sample in which something limited or stuck */
    /* controller */
    double y_1, y_2, target_1, rate, integral, u;
    int begun;
} World;

static double clip(double x, double limit) { return x > limit ? limit : x < -limit ? -limit : x; }
static double sign(double x) { return (x > 0.0) - (x < 0.0); }

/* ---- controllers, each from its published equation ---------------------------------------------- */

static double controller(World *w, double r, double y) {
    const Parameters *p = &w->p;
    double target = p->kind == PID || p->kind == PD ? p->derivative_weight * r - y : -y;
    if (!w->begun) {
        w->y_1 = w->y_2 = y;
        w->target_1 = target;
        w->begun = 1;
    }
    /* T_f d' + d = x', x' by the backward difference */
    double blend = p->filter_time / (p->filter_time + p->sample);
    w->rate = blend * w->rate + (1.0 - blend) * (target - w->target_1) / p->sample;
    double wanted = 0.0, error = 0.0;
    if (p->kind == SERVO_PD || p->kind == PD) {
        wanted = p->kp * (r - y) + p->kd * w->rate;
    } else if (p->kind == AXIS_PV) {
        wanted = p->kv * (p->kp * (r - y) - 0.5 * (y - w->y_2) / p->sample);
    } else if (p->kind == PID) {
        error = r - y;
        wanted = p->kp * error + w->integral + p->kd * w->rate;
    } else if (p->kind == CASCADE) {
        error = p->kp * (r - y) + w->rate; /* target is -y: its rate is minus the velocity */
        wanted = p->kv * error + w->integral;
    }
    double u = p->u_limit > 0.0 ? clip(wanted, p->u_limit) : wanted;
    w->integral += p->sample * (p->ki * error + fmin(p->anti_windup, 1.0 / p->sample) * (u - wanted));
    w->y_2 = w->y_1;
    w->y_1 = y;
    w->target_1 = target;
    return u;
}

/* ---- drive -------------------------------------------------------------------------------------- */

/* Command behind the static imperfections of the drive. */
static double drive(const World *w, const double *x, int *limited) {
    const Parameters *p = &w->p;
    double u = w->arrived * (1.0 + p->drive_gain_error);
    *limited = 0;
    if (p->uneven != 0.0) u += p->uneven * fabs(u);
    if (p->coarse > 0.0) u = p->coarse * floor(u / p->coarse + 0.5);
    if (p->iron_level > 0.0) u = p->iron_level * tanh(u / p->iron_level);
    if (p->heat_loss > 0.0) u *= 1.0 - p->heat_loss * x[HEAT];
    if (p->dead_width > 0.0) {
        *limited |= fabs(u) <= p->dead_width;
        u -= clip(u, p->dead_width);
    }
    double before = u;
    if (p->drive_limit > 0.0) u = clip(u, p->drive_limit);
    if (p->supply_limit > 0.0) /* what the back-EMF leaves of the supply */
        u = fmax(-p->supply_limit, fmin(p->supply_limit, u + p->supply_slope * x[V])) - p->supply_slope * x[V];
    *limited |= u != before;
    return u;
}

static double motor_torque(const World *w, const double *x) {
    const Parameters *p = &w->p;
    int limited;
    double u = p->drive_lag > 0.0 ? x[DRIVE] : p->drive_rate > 0.0 ? w->followed : drive(w, x, &limited);
    double torque = p->torque_lag > 0.0 ? x[TORQUE] : p->torque_gain * u;
    if (p->ripple != 0.0) torque *= 1.0 + p->ripple * cos(p->ripple_number * x[Q] + p->ripple_phase);
    return torque;
}

/* ---- torques on the motor ----------------------------------------------------------------------- */

/* Torque of the shaft on the load: contact at either side of the gap (Hunt, Crossley 1975). */
static double shaft(const World *w, const double *x) {
    const Parameters *p = &w->p;
    if (p->load_inertia <= 0.0) return 0.0;
    double twist = x[Q] - x[LOAD_Q], rate = x[V] - x[LOAD_V];
    if (p->gap <= 0.0) return p->shaft_stiffness * twist + p->shaft_damping * rate;
    double side = sign(twist), depth = fabs(twist) - 0.5 * p->gap;
    if (depth <= 0.0) return 0.0;
    double force = p->shaft_stiffness * pow(depth, p->contact_exponent) * (1.0 + p->contact_damping * side * rate);
    return side * fmax(0.0, force);
}

static double element_forces(const World *w, double q, double *forces) {
    double total = 0.0;
    for (int i = 0; i < ELEMENTS; ++i) {
        double limit = w->p.slip_force / ELEMENTS, travel = w->p.slip_length * (i + 1.0) / ELEMENTS;
        double force = clip(w->element[i] + limit / travel * (q - w->q_of_elements), limit);
        if (forces) forces[i] = force;
        total += force;
    }
    return total;
}

/* All torques on the motor but that of the hard friction. */
static double other_torques(const World *w, double t, const double *x) {
    const Parameters *p = &w->p;
    double q = x[Q], v = x[V];
    double total = motor_torque(w, x) - p->viscous * v - shaft(w, x) + p->push + w->load;
    if (p->drag != 0.0) total -= p->drag * v * fabs(v);
    if (p->cubic_drag != 0.0) total -= p->cubic_drag * v * v * v;
    if (p->rippled_drag != 0.0) total -= p->rippled_drag * v * sin(p->rippled_drag_number * q);
    if (p->root_friction != 0.0) total -= p->root_friction * sign(v) * sqrt(fabs(v));
    if (p->position_times_velocity != 0.0) total -= p->position_times_velocity * q * v;
    if (p->bristle_level > 0.0) {
        double z = x[BRISTLE], slip = p->bristle_stiffness * fabs(v) / p->bristle_level * z;
        total -= p->bristle_stiffness * z + p->bristle_damping * (v - slip);
    }
    if (p->slip_force > 0.0) total -= element_forces(w, q, NULL);
    if (p->wave_1 != 0.0)
        total += p->wave_1 * sin(p->wave_number_1 * q + p->wave_phase_1) +
                 p->wave_2 * sin(p->wave_number_2 * q + p->wave_phase_2) +
                 p->wave_3 * sin(p->wave_number_3 * q + p->wave_phase_3);
    if (p->pendulum != 0.0) total -= p->pendulum * sin(q + p->pendulum_phase);
    if (p->spring != 0.0) {
        double stretch = q - p->spring_rest;
        total -= p->spring * (stretch - clip(stretch, p->spring_dead_band));
    }
    if (p->cubic_spring != 0.0) total -= p->cubic_spring * q * q * q;
    if (p->hum != 0.0) total += p->hum * sin(2.0 * PI * p->hum_frequency * t + p->hum_phase);
    if (p->sweep != 0.0) {
        double turns = p->sweep_frequency * t + 0.5 * p->sweep_rate * t * t;
        total += p->sweep * sin(2.0 * PI * turns + p->sweep_phase);
    }
    if (t >= p->pulse_start && t < p->pulse_start + p->pulse_duration) total += p->pulse;
    return total;
}

/* Level of the hard friction for slip in a direction; at v = 0 it is the breakaway level. */
static double friction_level(const World *w, double t, const double *x, double direction) {
    const Parameters *p = &w->p;
    double level = direction > 0.0 ? p->friction_positive : p->friction_negative;
    if (p->friction_speed > 0.0) {
        double s = x[V] / p->friction_speed;
        double share = p->friction_shape > 0.5 ? 1.0 / (1.0 + s * s) : exp(-s * s);
        level += p->friction_breakaway * share;
    }
    if (p->friction_torque_share > 0.0) level += p->friction_torque_share * fabs(motor_torque(w, x));
    if (p->friction_wave != 0.0 && !(p->friction_wave_one_way > 0.5 && direction < 0.0))
        level += p->friction_wave * sin(p->friction_wave_number * x[Q] + p->friction_wave_phase);
    if (p->friction_growth != 0.0) level *= 1.0 + p->friction_growth * fmax(t, 0.0); /* [1/s] from the start */
    return fmax(0.0, level);
}

static int has_friction(const Parameters *p) {
    return p->friction_positive + p->friction_negative + p->friction_torque_share + p->friction_breakaway > 0.0;
}

/* ---- integration -------------------------------------------------------------------------------- */

static void slope(const World *w, double t, const double *x, double *dx) {
    const Parameters *p = &w->p;
    int limited;
    double u = p->drive_rate > 0.0 ? w->followed : drive(w, x, &limited);
    memset(dx, 0, N_STATES * sizeof *dx);
    if (p->drive_lag > 0.0) dx[DRIVE] = (u - x[DRIVE]) / p->drive_lag;
    if (p->torque_lag > 0.0)
        dx[TORQUE] = (p->torque_gain * (p->drive_lag > 0.0 ? x[DRIVE] : u) - x[TORQUE]) / p->torque_lag;
    if (p->heat_time > 0.0) {
        double load = w->arrived / p->heat_scale;
        dx[HEAT] = (load * load - x[HEAT]) / p->heat_time;
    }
    if (p->load_inertia > 0.0) {
        dx[LOAD_Q] = x[LOAD_V];
        dx[LOAD_V] = shaft(w, x) / p->load_inertia;
    }
    if (p->sensor_time > 0.0) dx[SENSED] = (x[Q] - x[SENSED]) / p->sensor_time;
    if (w->stuck) return;
    double torque = other_torques(w, t, x);
    if (w->direction) torque -= w->direction * friction_level(w, t, x, w->direction);
    dx[Q] = x[V];
    dx[V] = torque / (p->inertia + p->load_inertia_extra);
    if (p->bristle_level > 0.0)
        dx[BRISTLE] = x[V] - p->bristle_stiffness * fabs(x[V]) / p->bristle_level * x[BRISTLE];
}

static void runge_kutta(const World *w, double t, double h, double *end) {
    static const double at[] = {0.0, 0.5, 0.5, 1.0}, weight[] = {1.0, 2.0, 2.0, 1.0};
    double k[N_STATES] = {0}, x[N_STATES], sum[N_STATES] = {0};
    for (int stage = 0; stage < 4; ++stage) {
        for (int i = 0; i < N_STATES; ++i) x[i] = w->x[i] + at[stage] * h * k[i];
        slope(w, t + at[stage] * h, x, k);
        for (int i = 0; i < N_STATES; ++i) sum[i] += weight[stage] * k[i];
    }
    for (int i = 0; i < N_STATES; ++i) end[i] = w->x[i] + h / 6.0 * sum[i];
}

/* Sticks or slips from rest, by the torque on the surface now. */
static void settle_surface(World *w, double t) {
    double torque = other_torques(w, t, w->x);
    double towards = torque >= 0.0 ? 1.0 : -1.0;
    w->stuck = fabs(torque) <= friction_level(w, t, w->x, towards);
    w->direction = (int)towards;
}

/* One smooth piece of at most h; answers its length, which ends where the velocity meets zero. */
static double piece(World *w, double t, double h) {
    double end[N_STATES];
    if (w->direction && w->x[V] == 0.0) settle_surface(w, t);
    runge_kutta(w, t, h, end);
    if (w->direction && !w->stuck && end[V] * w->direction < 0.0) {
        if (w->x[V] == 0.0) { /* pushed back at once: it rests */
            w->stuck = 1;
            runge_kutta(w, t, h, end);
        } else {
            double low = 0.0, high = h;
            for (int i = 0; i < 40 && high - low > 1e-14; ++i) {
                double middle = 0.5 * (low + high);
                runge_kutta(w, t, middle, end);
                if (end[V] * w->direction > 0.0) low = middle;
                else high = middle;
            }
            h = high;
            runge_kutta(w, t, h, end);
            end[V] = 0.0;
        }
    }
    memcpy(w->x, end, sizeof end);
    if (w->p.slip_force > 0.0) {
        double forces[ELEMENTS];
        element_forces(w, w->x[Q], forces);
        memcpy(w->element, forces, sizeof forces);
        w->q_of_elements = w->x[Q];
    }
    return h;
}

static void note_activity(World *w, double t, double h) {
    const Parameters *p = &w->p;
    int limited;
    drive(w, w->x, &limited);
    if (p->gap > 0.0) limited |= fabs(w->x[Q] - w->x[LOAD_Q]) < 0.5 * p->gap;
    limited |= p->pulse != 0.0 && t >= p->pulse_start && t < p->pulse_start + p->pulse_duration;
    limited |= w->stuck;
    if (limited) w->active += h;
}

/* A command arrives, behind the play of the drive where there is one. */
static void take_command(World *w, double u) { w->arrived = u - clip(u - w->arrived, 0.5 * w->p.drive_play); }

/* From t to end, cut at arrivals of commands. */
static void advance(World *w, double t, double end) {
    const Parameters *p = &w->p;
    while (t < end - 1e-13) {
        while (w->head < w->tail && w->due[w->head % QUEUE] <= t + 1e-13)
            take_command(w, w->waiting[w->head++ % QUEUE]);
        double until = fmin(t + INNER, end);
        if (w->head < w->tail) until = fmin(until, w->due[w->head % QUEUE]);
        double followed = w->followed;
        if (p->drive_rate > 0.0) {
            int limited;
            double gap = drive(w, w->x, &limited) - followed, most = p->drive_rate * (until - t);
            followed += clip(gap, most);
            w->followed = followed;
            if (fabs(gap) > most) { /* still under way: its mean over this step acts */
                w->followed -= 0.5 * clip(gap, most);
                w->active += until - t;
            }
        }
        while (t < until - 1e-13) {
            double done = piece(w, t, until - t);
            note_activity(w, t, done);
            t += done;
        }
        w->followed = followed;
        t = until;
    }
}

static double reading(World *w, double noise) {
    const Parameters *p = &w->p;
    double q = p->sensor_time > 0.0 ? w->x[SENSED] : w->x[Q];
    double e = p->sensor_eccentricity, angle = q - p->sensor_phase;
    /* angle seen by a head at distance 1 from a disc whose centre is off by e */
    if (e != 0.0) q += atan2(e * sin(angle), 1.0 - e * cos(angle));
    if (p->play > 0.0) {
        w->followed_by_sensor += q - w->followed_by_sensor - clip(q - w->followed_by_sensor, 0.5 * p->play);
        q = w->followed_by_sensor;
    }
    q += p->bend * q * q + p->line_error * sin(p->line_number * q);
    q = q * (1.0 + p->sensor_scale) + p->sensor_zero + noise;
    return p->quantum > 0.0 ? p->quantum * floor(q / p->quantum + 0.5) : q;
}

/* ---- what Python calls -------------------------------------------------------------------------- */

VISIBLE int truth_parameters(void) { return N_PARAMETERS; }
VISIBLE const char *truth_name(int index) { return names[index]; }
VISIBLE int truth_columns(void) { return COLUMNS; }

/* Rows of READING..ACTIVE at t = k * sample, k = 0..rows-1. Before, `preroll` samples under the
 * first reference bring the plant to rest. For kind 0 the reference is the command itself.
 * noise, load: [preroll + rows] added to the readings, and held on the shaft over a sample. Answers 0, or 1 where the plant has diverged. */
VISIBLE int truth_run(const double *parameters, long preroll, long rows, const double *reference,
                      const double *noise, const double *load, double *out) {
    World w;
    memset(&w, 0, sizeof w);
    memcpy(&w.p, parameters, sizeof w.p);
    if (w.p.sample <= 0.0) w.p.sample = MILLISECOND;
    const double sample = w.p.sample;
    w.x[Q] = w.x[LOAD_Q] = w.x[SENSED] = w.q_of_elements = w.followed_by_sensor = w.p.start;
    w.direction = has_friction(&w.p);
    int still = 0; /* samples in which nothing at all has changed */
    for (long k = -preroll; k < rows; ++k) {
        double was[N_STATES], u_was = w.u;
        memcpy(was, w.x, sizeof was);
        double t = (double)k * sample, wanted = reference[k < 0 ? 0 : k];
        double y = reading(&w, noise[preroll + k]), before = w.u;
        w.u = w.p.kind < 0.5 ? wanted : controller(&w, wanted, y);
        w.due[w.tail % QUEUE] = t + w.p.delay;
        w.waiting[w.tail++ % QUEUE] = w.u;
        double *row = k < 0 ? NULL : out + k * COLUMNS;
        if (row) {
            row[READING] = y;
            row[HELD] = before;
            row[NEW] = w.u;
            row[POSITION] = w.x[Q];
            row[VELOCITY] = w.x[V];
        }
        w.active = 0.0;
        w.load = load[preroll + k];
        advance(&w, t, (double)(k + 1) * sample);
        if (row) row[ACTIVE] = w.active / sample;
        int quiet = noise[preroll + k] == 0.0 && w.load == 0.0;
        still = !memcmp(was, w.x, sizeof was) && w.u == u_was && quiet ? still + 1 : 0;
        if (still > 20 && k < -1) k = -2; /* longer than any delay: the rest of the wait is the same */
        if (!isfinite(w.x[Q]) || !isfinite(w.x[V])) return 1;
    }
    return 0;
}
