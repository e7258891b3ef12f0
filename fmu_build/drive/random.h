/* Normal random numbers that are the same on every platform, up to rounding of log and cos. */
#ifndef GMFBO_DRIVE_RANDOM_H
#define GMFBO_DRIVE_RANDOM_H

#include <math.h>
#include <stdint.h>

/* splitmix64 (Steele, Lea, Flood 2014): the state counts up, a hash of it is the number. */
static inline uint64_t random_bits(uint64_t *state) {
    uint64_t z = *state += UINT64_C(0x9E3779B97F4A7C15);
    z = (z ^ (z >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94D049BB133111EB);
    return z ^ (z >> 31);
}

/* Uniform in (0, 1): 53 bits, moved by half a step so that neither end can come. */
static inline double random_uniform(uint64_t *state) {
    return ((double)(random_bits(state) >> 11) + 0.5) * 0x1p-53;
}

/* Standard normal (Box, Muller 1958); the second number of each pair is not used. */
static inline double random_normal(uint64_t *state) {
    double radius = sqrt(-2.0 * log(random_uniform(state)));
    return radius * cos(6.283185307179586 * random_uniform(state));
}

#endif
