/* Inverse flux-linkage map (psi_d, psi_q) -> (i_d, i_q): a cubic B-spline over a table.
 *
 * The values at the nodes are the spline's coefficients (control points): the curve averages
 * over neighbouring nodes, so noise on them gives a smooth map. Flux along d is counted from the
 * flux of the magnets. */
#ifndef GMFBO_DRIVE_FLUX_MAP_H
#define GMFBO_DRIVE_FLUX_MAP_H

#include <stdint.h>

#include "random.h"

/* MAP_NODES x MAP_NODES nodes of the table; model.toml and resources/flux_map.txt hold the same
 * number. Four ghosts beyond each edge continue the nominal table linearly, so that alterations
 * fade within two cells outside and the map is linear and monotone from there on. */
enum { MAP_NODES = 5, MAP_GHOSTS = 4, MAP_SIZE = MAP_NODES + 2 * MAP_GHOSTS };

typedef struct {
    double half_width;                        /* [Wb] the table covers plus and minus this */
    double cells_per_flux;                    /* [1/Wb] */
    double table[MAP_NODES][MAP_NODES][2];    /* [A] nominal i_d, i_q; rows along psi_d */
    double nodes[MAP_SIZE][MAP_SIZE][2];      /* [A] the same, altered and with its ghosts */
} FluxMap;

/* ---- making the map -------------------------------------------------------------------- */

/* Ghosts along one line of MAP_SIZE nodes, `stride` doubles apart, whose inner nodes are set. */
static inline void flux_map_extend(double *line, int stride) {
    double *first = line + MAP_GHOSTS * stride, *last = first + (MAP_NODES - 1) * stride;
    for (int k = 1; k <= MAP_GHOSTS; ++k) {
        first[-k * stride] = first[0] - k * (first[stride] - first[0]);
        last[k * stride] = last[0] + k * (last[0] - last[-stride]);
    }
}

/* Difference of the largest and the smallest value of one current in the nominal table [A]. */
static inline double flux_map_range(const FluxMap *map, int axis) {
    double low = map->table[0][0][axis], high = low;
    for (int i = 0; i < MAP_NODES; ++i) {
        for (int j = 0; j < MAP_NODES; ++j) {
            low = fmin(low, map->table[i][j][axis]);
            high = fmax(high, map->table[i][j][axis]);
        }
    }
    return high - low;
}

/* Nodes from the nominal table: ghosts first, then, at the table's own nodes only, noise of
 * standard deviation `noise` times the range of the data, and the deltas [A] (row-major).
 * Numbers are drawn for i_d row by row, then for i_q. */
static inline void flux_map_alter(FluxMap *map, double noise, uint64_t seed, const double *delta_d,
                                  const double *delta_q) {
    for (int axis = 0; axis < 2; ++axis) {
        for (int i = 0; i < MAP_NODES; ++i) {
            for (int j = 0; j < MAP_NODES; ++j)
                map->nodes[MAP_GHOSTS + i][MAP_GHOSTS + j][axis] = map->table[i][j][axis];
            flux_map_extend(&map->nodes[MAP_GHOSTS + i][0][axis], 2);
        }
        for (int j = 0; j < MAP_SIZE; ++j) flux_map_extend(&map->nodes[0][j][axis], 2 * MAP_SIZE);
    }
    uint64_t state = seed;
    for (int axis = 0; axis < 2; ++axis) {
        const double *delta = axis == 0 ? delta_d : delta_q;
        double deviation = noise * flux_map_range(map, axis);
        for (int i = 0; i < MAP_NODES; ++i)
            for (int j = 0; j < MAP_NODES; ++j)
                map->nodes[MAP_GHOSTS + i][MAP_GHOSTS + j][axis] +=
                    deviation * random_normal(&state) + delta[i * MAP_NODES + j];
    }
}

/* The altered nodes [A] of the table itself, row-major. */
static inline void flux_map_read_out(const FluxMap *map, double *node_d, double *node_q) {
    for (int i = 0; i < MAP_NODES; ++i) {
        for (int j = 0; j < MAP_NODES; ++j) {
            const double *node = map->nodes[MAP_GHOSTS + i][MAP_GHOSTS + j];
            node_d[i * MAP_NODES + j] = node[0];
            node_q[i * MAP_NODES + j] = node[1];
        }
    }
}

/* ---- looking it up --------------------------------------------------------------------- */

/* Weights of the four nodes around x [cells from the first ghost]; returns the first of them.
 * Beyond the last full cell the weights go on linearly, and with them the map. */
static inline int flux_map_weights(double x, double weight[4]) {
    double inside = x > 1.0 ? (x < MAP_SIZE - 2 ? x : MAP_SIZE - 2) : 1.0;
    int cell = (int)inside < MAP_SIZE - 3 ? (int)inside : MAP_SIZE - 3;
    double t = inside - cell, s = 1.0 - t;
    weight[0] = s * s * s / 6.0;
    weight[1] = 2.0 / 3.0 - 0.5 * t * t * (1.0 + s);
    weight[2] = 2.0 / 3.0 - 0.5 * s * s * (1.0 + t);
    weight[3] = t * t * t / 6.0;
    if (x != inside) {
        double beyond = x - inside;
        weight[0] -= 0.5 * s * s * beyond;
        weight[1] -= (2.0 * t - 1.5 * t * t) * beyond;
        weight[2] += (2.0 * s - 1.5 * s * s) * beyond;
        weight[3] += 0.5 * t * t * beyond;
    }
    return cell - 1;
}

/* Currents [A] at a flux [Wb], the d component counted from the flux of the magnets. */
static inline void flux_map_current(const FluxMap *map, double flux_d, double flux_q, double current[2]) {
    double along_d[4], along_q[4], i_d = 0.0, i_q = 0.0;
    int row = flux_map_weights((flux_d + map->half_width) * map->cells_per_flux + MAP_GHOSTS, along_d);
    int column = flux_map_weights((flux_q + map->half_width) * map->cells_per_flux + MAP_GHOSTS, along_q);
    for (int i = 0; i < 4; ++i) {
        const double(*node)[2] = &map->nodes[row + i][column];
        i_d += along_d[i] * (along_q[0] * node[0][0] + along_q[1] * node[1][0] + along_q[2] * node[2][0] +
                             along_q[3] * node[3][0]);
        i_q += along_d[i] * (along_q[0] * node[0][1] + along_q[1] * node[1][1] + along_q[2] * node[2][1] +
                             along_q[3] * node[3][1]);
    }
    current[0] = i_d;
    current[1] = i_q;
}

#endif
