"""What effects that repeat over the position have in common."""

from __future__ import annotations

import math

import numpy as np

from gmfbo.physics.effect import EffectParameter, Range, Values
from gmfbo.physics.excitation import Excitation
from gmfbo.physics.states import Array, States
from gmfbo.physics.units import number

# Cycles over the stroke where no line was found: a shape to state detectable sizes for.
_CYCLES = 10.0
_LINES = 4


def wavenumbers(excitation: Excitation) -> tuple[float, ...]:
    """Give the lines to start from: those found in the recordings, strongest first, at most four.

    Returns
    -------
    tuple of float
        [rad per position unit]; a typical one where none was found.
    """
    return excitation.wavenumbers[:_LINES] or (2.0 * math.pi * _CYCLES / excitation.stroke,)


def lowest(excitation: Excitation) -> float:
    """Slowest line that a fit may reach: half a cycle over the stroke [rad/position unit]."""
    return min(math.pi / excitation.stroke, 0.5 * min(wavenumbers(excitation)))


def wavenumber(name: str = "wavenumber", low: Range = lowest) -> EffectParameter:
    """Make the parameter that holds a line; its scale is one radian of phase over the stroke."""

    def high(excitation: Excitation) -> float:
        visible = 2.0 * math.pi / (4.0 * excitation.resolution)
        return max(visible, 2.0 * max(wavenumbers(excitation)))

    return EffectParameter(
        name,
        "Wavenumber",
        "1/position",
        low=low,
        high=high,
        scale=lambda e: 1.0 / e.stroke,
        hidden=True,
    )


def wave(states: States, line: float, sine: float, cosine: float) -> Array:
    """Evaluate sine*sin(line*q) + cosine*cos(line*q) along the positions, shape (n,)."""
    phase = line * states.position
    return np.asarray(sine * np.sin(phase) + cosine * np.cos(phase), dtype=np.float64)


def lines(states: States, parameters: Values) -> Array:
    """Sum the numbered lines, `wavenumber_1`, `sine_1`, `cosine_1` and so on, shape (n,)."""
    total = np.zeros(len(states.position))
    for name, line in parameters.items():
        if name.startswith("wavenumber_") and line:
            suffix = name.removeprefix("wavenumber")
            sine, cosine = parameters["sine" + suffix], parameters["cosine" + suffix]
            total = total + wave(states, line, sine, cosine)
    return total


def too_short(excitation: Excitation) -> str | None:
    """Less than an eighth of a turn shows hardly a cycle of any line worth naming."""
    if excitation.angular and excitation.stroke < 0.25 * math.pi:
        return "the axis turns less than 45 degrees"
    return None


def amplitude(parameters: Values, suffix: str = "") -> float:
    """Amplitude of one line."""
    return math.hypot(parameters["sine" + suffix], parameters["cosine" + suffix])


def largest_amplitude(parameters: Values) -> float:
    """Amplitude of the strongest of the numbered lines."""
    suffixes = [name[4:] for name in parameters if name.startswith("sine_")]
    return max(amplitude(parameters, suffix) for suffix in suffixes)


def cycles(line: float, angular: bool) -> str:
    """Say how often a line repeats: `7 cycles a turn`, or `400 cycles per m` along a length."""
    often = number(line if angular else line / (2.0 * math.pi))
    cycle = "one cycle" if often == "1" else f"{often} cycles"
    return f"{cycle} {'a turn' if angular else 'per m'}"
