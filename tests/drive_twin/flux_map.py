"""The flux map written again in NumPy, from its description alone."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

NODES, HALF_WIDTH, GHOSTS = 5, 15e-3, 4  # half width in [Wb]
INDUCTANCE_D, INDUCTANCE_Q = 3.0e-4, 3.6e-4  # [H]
SATURATION = 4.5e6  # [A/Wb^3]
MAGNETS = 0.0154  # [Wb]
SPACING = 2.0 * HALF_WIDTH / (NODES - 1)  # [Wb]

Array = NDArray[np.float64]


def formula(u: Array, w: Array) -> Array:
    """Nominal currents [A], shape (2, ...); u is the flux [Wb] along d from that of the magnets."""
    cubic = SATURATION * (u**2 + w**2)
    return np.stack([u / INDUCTANCE_D + cubic * u, w / INDUCTANCE_Q + cubic * w])


def magnetic_energy(u: Array, w: Array) -> Array:
    """Energy [J] whose gradient is `formula`."""
    linear = u**2 / (2.0 * INDUCTANCE_D) + w**2 / (2.0 * INDUCTANCE_Q)
    return linear + SATURATION * (u**2 + w**2) ** 2 / 4.0


def kernel(t: Array) -> Array:
    """Cubic B-spline on unit knots, centred on 0."""
    t = np.abs(t)
    return np.where(
        t < 1.0, 2.0 / 3.0 - t**2 + t**3 / 2.0, np.where(t < 2.0, (2.0 - t) ** 3 / 6.0, 0.0)
    )


def nominal_table() -> Array:
    """Coefficients [A], shape (2, NODES, NODES), fitted to the formula on a wider grid."""
    nodes = np.arange(-8, 9)
    points = np.linspace(-7.0, 7.0, 57)
    inverse = np.linalg.pinv(kernel(points[:, None] - nodes[None, :]))
    values = formula(*np.meshgrid(SPACING * points, SPACING * points, indexing="ij"))
    middle = slice(8 - NODES // 2, 8 + NODES // 2 + 1)
    return np.stack([(inverse @ table @ inverse.T)[middle, middle] for table in values])


def linear_table() -> Array:
    """Coefficients [A] of the map without saturation."""
    x = np.linspace(-HALF_WIDTH, HALF_WIDTH, NODES)
    u, w = np.meshgrid(x, x, indexing="ij")
    return np.stack([u / INDUCTANCE_D, w / INDUCTANCE_Q])


def with_ghosts(table: Array) -> Array:
    """Continue each table linearly by four nodes on all sides, first along q, then along d."""
    for axis in (2, 1):
        first, second = np.take(table, [0], axis), np.take(table, [1], axis)
        last, before = np.take(table, [-1], axis), np.take(table, [-2], axis)
        low = [first - k * (second - first) for k in range(GHOSTS, 0, -1)]
        high = [last + k * (last - before) for k in range(1, GHOSTS + 1)]
        table = np.concatenate([*low, table, *high], axis=axis)
    return table


def currents(padded: Array, u: float, w: float) -> Array:
    """Currents [A], shape (2,), between the second and the last but one node of `padded`."""
    index = np.arange(-GHOSTS, NODES + GHOSTS, dtype=np.float64)
    along_d = kernel(np.float64((u + HALF_WIDTH) / SPACING) - index)
    along_q = kernel(np.float64((w + HALF_WIDTH) / SPACING) - index)
    return np.asarray(np.einsum("kij,i,j->k", padded, along_d, along_q))


def normal_numbers(seed: int) -> Iterator[float]:
    """Splitmix64 from `seed`, two uniform numbers to each normal one (Box and Muller)."""
    mask = 2**64 - 1

    def uniform() -> float:
        nonlocal seed
        seed = (seed + 0x9E3779B97F4A7C15) & mask
        z = ((seed ^ (seed >> 30)) * 0xBF58476D1CE4E5B9) & mask
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & mask
        return (((z ^ (z >> 31)) >> 11) + 0.5) * 2.0**-53

    while True:
        radius = math.sqrt(-2.0 * math.log(uniform()))
        yield radius * math.cos(2.0 * math.pi * uniform())


def noise_table(noise: float, seed: int) -> Array:
    """Noise [A], shape (2, NODES, NODES): all of i_d row by row, then i_q."""
    table, numbers = nominal_table(), normal_numbers(seed)
    deviation = noise * np.ptp(table, axis=(1, 2))
    drawn = np.array([next(numbers) for _ in range(table.size)]).reshape(table.shape)
    return np.asarray(deviation[:, None, None] * drawn)


def map_deltas(deltas: Array) -> dict[str, float]:
    """FMU parameters of corrections [A], shape (2, NODES, NODES)."""
    return {
        f"map.delta_{axis}[{i + 1},{j + 1}]": float(deltas[k, i, j])
        for k, axis in enumerate("dq")
        for i in range(NODES)
        for j in range(NODES)
    }
