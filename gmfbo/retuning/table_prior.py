"""Prior of a lookup table: the true table is smooth, and the given nodes are noisy.

The true table f is smooth: its second differences are normal numbers of standard deviation
`BEND` times its range (a thin plate, Wahba 1990, Spline models for observational data). The table
of the twin is f with independent normal noise at the nodes, whose likeliest size follows from the
table's roughness. The penalty is on the roughness of the corrected table, not of the correction,
since a correction of noise is rough.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

BEND = 0.1
"""Second difference of neighbouring nodes over the range of the table. The flux map of the drive
twin, which saturates by a quarter, has 0.05."""

LEAST_NOISE = 1e-3
"""Least noise of a table's nodes, as a share of the range: the digits of a data sheet."""

FALL = 0.02
"""Share of the range by which a table that rises may fall between two nodes."""

_ROUNDS = 4
_NOISES = np.geomspace(LEAST_NOISE, 3.0, 60)


@dataclass(frozen=True, eq=False)
class TablePrior:
    """Prior of a smooth table with noisy nodes; n nodes.

    Attributes
    ----------
    nodes : ndarray, shape (n,)
        The table as it is, row by row.
    scale : float
        Range of the smooth table, the unit of all other values [unit of the nodes].
    noise : float
        Standard deviation of the nodes' noise over `scale`.
    bending : ndarray, shape (r, n)
        Second differences of the nodes, over `BEND`.
    slopes : ndarray, shape (s, n)
        Differences of neighbours that should not be negative, over `FALL`.
    """

    nodes: NDArray[np.float64]
    scale: float
    noise: float
    bending: NDArray[np.float64]
    slopes: NDArray[np.float64]

    @classmethod
    def of(
        cls, nodes: NDArray[np.float64], shape: tuple[int, ...], rising: int | None = None
    ) -> Self:
        """Estimate the noise of a table from its roughness.

        Parameters
        ----------
        nodes : ndarray, shape (n,)
            Row by row.
        shape : tuple of int
            One or two numbers whose product is n.
        rising : int, optional
            Axis along which the table does not fall.
        """
        bending = second_differences(shape) / BEND
        slopes = np.empty((0, nodes.size)) if rising is None else differences(shape, rising) / FALL
        scale = float(np.ptp(nodes)) or 1.0
        noise = LEAST_NOISE
        for _ in range(_ROUNDS):
            # The noise widens the range, and the range is the unit of the noise.
            noise = _likeliest_noise(nodes / scale, bending)
            smooth = nodes + scale * _smoothing_change(nodes / scale, noise, bending)
            scale = float(np.ptp(smooth)) or scale
        return cls(nodes, scale, noise, bending, slopes)

    @property
    def smoothing_change(self) -> NDArray[np.float64]:
        """Most probable change of the nodes without any recording, shape (n,) [their unit]."""
        return self.scale * _smoothing_change(self.nodes / self.scale, self.noise, self.bending)

    def rows(self, change: NDArray[np.float64]) -> NDArray[np.float64]:
        """Residuals of the prior, whose squares add up to minus twice its logarithm.

        Parameters
        ----------
        change : ndarray, shape (n,)
            Of the nodes [their unit].
        """
        table = (self.nodes + change) / self.scale
        falling = np.minimum(self.slopes @ table, 0.0)
        return np.concatenate([change / (self.scale * self.noise), self.bending @ table, falling])

    def slope_of_rows(self, change: NDArray[np.float64]) -> NDArray[np.float64]:
        """Derivative of `rows` with respect to the change, shape (n + r + s, n)."""
        own = np.eye(self.nodes.size) / (self.scale * self.noise)
        falls = self.slopes @ (self.nodes + change) < 0.0
        return np.vstack(
            [own, self.bending / self.scale, falls[:, None] * self.slopes / self.scale]
        )


def second_differences(shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Rows that take the second differences of a table, mixed ones with their weight of two.

    Parameters
    ----------
    shape : tuple of int
        One or two numbers.

    Returns
    -------
    ndarray, shape (r, n)
        Applied to the nodes row by row; a plane has none.
    """
    identity = np.eye(int(np.prod(shape))).reshape(*shape, -1)
    rows = [np.diff(identity, 2, axis=axis) for axis in range(len(shape))]
    if len(shape) == 2:
        rows.append(np.sqrt(2.0) * np.diff(np.diff(identity, axis=0), axis=1))
    return np.concatenate([part.reshape(-1, identity.shape[-1]) for part in rows])


def differences(shape: tuple[int, ...], axis: int) -> NDArray[np.float64]:
    """Rows, shape (s, n), that take the differences of neighbours along an axis."""
    identity = np.eye(int(np.prod(shape))).reshape(*shape, -1)
    return np.diff(identity, axis=axis).reshape(-1, identity.shape[-1])


def _smoothing_change(
    table: NDArray[np.float64], noise: float, bending: NDArray[np.float64]
) -> NDArray[np.float64]:
    precision = np.eye(table.size) / noise**2 + bending.T @ bending
    return np.asarray(np.linalg.solve(precision, -bending.T @ (bending @ table)), dtype=np.float64)


def _likeliest_noise(table: NDArray[np.float64], bending: NDArray[np.float64]) -> float:
    """Likeliest noise by restricted likelihood, without the part that a plane explains."""
    stiffness, modes = np.linalg.eigh(bending.T @ bending)
    bent = stiffness > 1e-9 * stiffness[-1]
    amplitudes = (modes.T @ table)[bent]
    losses = []
    for noise in _NOISES:
        variance = noise**2 + 1.0 / stiffness[bent]
        losses.append(float(np.sum(np.log(variance) + amplitudes**2 / variance)))
    return float(_NOISES[int(np.argmin(losses))])
