"""Stability margins of a loop, from its frequency response."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import PchipInterpolator

MARGINS = ("phase_margin", "gain_margin", "ms")
"""Phase margin [deg], gain margin (a factor) and the largest sensitivity (a factor)."""

AT_LEAST = ("phase_margin", "gain_margin")
"""Margins of which more is better; `ms` is limited from above."""

MOST_FACTOR = 1000.0
"""Gain margin of a loop whose phase does not cross -180 deg, and `ms` of an unstable loop."""

UNSTABLE = {"phase_margin": 0.0, "gain_margin": 0.0, "ms": MOST_FACTOR}
"""Margins of a loop that is not stable."""

_BETWEEN = 200  # interpolated points between two measured frequencies


def margins(frequency: ArrayLike, loop: ArrayLike) -> dict[str, float]:
    """Margins of a stable closed loop.

    L is interpolated between the frequencies, its logarithm and its unwrapped phase over the
    logarithm of the frequency, monotone between neighbours (Fritsch and Carlson 1980). Of several
    crossings the worst counts, as in python-control.

    Parameters
    ----------
    frequency : array_like, shape (m,)
        [Hz], increasing and positive.
    loop : array_like of complex, shape (m,)
        L: controller, actuator, plant and sensor in a row, negative feedback left out.

    Returns
    -------
    dict of str to float
        phase_margin [deg]: 180 deg plus the phase where `|L|` crosses 1, 180 where it does not;
        gain_margin: 1 / `|L|` where the phase crosses -180 deg with `|L|` below 1; ms: the largest
        `|1 / (1 + L)|`.
    """
    place = np.log(np.asarray(frequency, dtype=float))
    response = np.asarray(loop, dtype=complex)
    steps = np.linspace(0.0, 1.0, _BETWEEN, endpoint=False)
    fine = np.append((place[:-1, None] + steps * np.diff(place)[:, None]).ravel(), place[-1])
    gain = PchipInterpolator(place, np.log(np.abs(response)))(fine)
    phase = PchipInterpolator(place, np.unwrap(np.angle(response)))(fine)
    between = np.exp(gain + 1j * phase)
    at_one = _crossings(gain, phase)
    # The distance from -180 deg, whatever the turn in which the phase was unwrapped.
    apart = [abs(_wrapped(angle + np.pi)) for angle in at_one]
    turned = _wrapped(phase + np.pi)
    near = np.abs(turned) < 0.5 * np.pi
    at_half = _crossings(np.where(near, turned, np.nan), gain)
    below = [value for value in at_half if value < 0.0]
    return {
        "phase_margin": float(np.degrees(min(apart))) if apart else 180.0,
        "gain_margin": min(float(np.exp(-max(below))), MOST_FACTOR) if below else MOST_FACTOR,
        "ms": float(np.abs(1.0 / (1.0 + between)).max()),
    }


def _crossings(values: NDArray[np.float64], along: NDArray[np.float64]) -> list[float]:
    """What `along` is where `values` cross zero, by the line between neighbours."""
    product = values[:-1] * values[1:]
    rows = np.flatnonzero(product <= 0.0)
    found = []
    for row in rows:
        rise = values[row + 1] - values[row]
        share = 0.0 if rise == 0.0 else -values[row] / rise
        found.append(float(along[row] + share * (along[row + 1] - along[row])))
    return found


def _wrapped(angle: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """Angle in [-pi, pi)."""
    return np.asarray((np.asarray(angle) + np.pi) % (2.0 * np.pi) - np.pi)
