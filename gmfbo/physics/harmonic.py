"""Common parts of effects that repeat over the position."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from gmfbo.physics.effect import EffectParameter, Range, Values
from gmfbo.physics.excitation import Excitation
from gmfbo.physics.states import Array, States
from gmfbo.units import number

# Cycles over the stroke at which a detectable size is stated where no line was found.
_CYCLES = 10.0
_ALONE = 4  # lines tried one at a time
_TOLD = 3  # lines that a sentence names

_LEAST_CYCLES = 1.5
"""Over the stroke. Fewer cycles look like any smooth torque over the position, such as a spring."""

MOST = 8
"""Lines that cogging may have in `physics.fmu`."""


def wavenumbers(excitation: Excitation) -> tuple[float, ...]:
    """Start lines: at most MOST found in the recordings, strongest first.

    Returns
    -------
    tuple of float
        [rad per position unit]; a typical one where none was found.
    """
    return excitation.wavenumbers[:MOST] or (_typical(excitation),)


def repeating(excitation: Excitation) -> tuple[float, ...]:
    """Start lines with enough cycles; a typical one where none has.

    Returns
    -------
    tuple of float
        [rad per position unit]
    """
    found = wavenumbers(excitation)
    return tuple(n for n in found if repeats(n, excitation)) or (_typical(excitation),)


def _typical(excitation: Excitation) -> float:
    return 2.0 * math.pi * _CYCLES / excitation.stroke


def starts(excitation: Excitation, size: float) -> list[dict[str, float]]:
    """Start from each of the strongest lines alone.

    Parameters
    ----------
    excitation : Excitation
        With the lines found in the recordings.
    size : float
        Of sine and cosine [unit of the amplitude].
    """
    found = repeating(excitation)[:_ALONE]
    return [{"wavenumber_1": line, "sine_1": size, "cosine_1": size} for line in found]


def repeats(line: float, excitation: Excitation) -> bool:
    """Whether a line has enough cycles to be told from a smooth curve over the position.

    Parameters
    ----------
    line : float
        [rad per position unit]
    excitation : Excitation
        Excitation by the recordings.
    """
    return line * excitation.stroke >= 2.0 * math.pi * _LEAST_CYCLES


def lowest(excitation: Excitation) -> float:
    """Lowest wavenumber of a fit: half a cycle over the stroke [rad/position unit]."""
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
    """Reason if the stroke is below an eighth of a turn, too short for a cycle of most lines."""
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


def strongest_first(parameters: Values) -> dict[str, float]:
    """Renumber lines by their amplitude; other parameters are kept."""
    tails = [
        name.removeprefix("wavenumber") for name in parameters if name.startswith("wavenumber_")
    ]
    ranked = sorted(tails, key=lambda tail: -amplitude(parameters, tail))
    kinds = ("wavenumber", "sine", "cosine")
    own = {kind + tail for kind in kinds for tail in tails}
    return {
        **{name: value for name, value in parameters.items() if name not in own},
        **{
            f"{kind}_{place}": parameters[kind + tail]
            for place, tail in enumerate(ranked, 1)
            for kind in kinds
        },
    }


def told(parameters: Values, angular: bool, sizes: Callable[[float], str] | None = None) -> str:
    """Words for the strongest lines: `7, 28 and 36 cycles a turn and 2 weaker lines`.

    Parameters
    ----------
    parameters : mapping of str to float
        Numbered lines.
    angular : bool
        The position is an angle.
    sizes : callable, optional
        Words for an amplitude, put before each line: `0.05 N m with 7`.
    """
    ranked = strongest_first(parameters)
    count = sum(name.startswith("wavenumber_") for name in ranked)
    shown = range(1, min(count, _TOLD) + 1)
    often = [cycles(ranked[f"wavenumber_{i}"], angular) for i in shown]
    texts = [*(text.partition(" cycle")[0] for text in often[:-1]), often[-1]]
    if sizes is not None:
        amplitudes = [sizes(amplitude(ranked, f"_{i}")) for i in shown]
        texts = [f"{size} with {text}" for size, text in zip(amplitudes, texts, strict=True)]
    more = f" and {count - _TOLD} weaker line{'s' if count > _TOLD + 1 else ''}"
    return " and ".join(filter(None, [", ".join(texts[:-1]), texts[-1]])) + (
        more if count > _TOLD else ""
    )


def cycles(line: float, angular: bool) -> str:
    """Words for a line: `7 cycles a turn`, or `400 cycles per m` along a length."""
    often = number(line if angular else line / (2.0 * math.pi))
    cycle = "one cycle" if often == "1" else f"{often} cycles"
    return f"{cycle} {'a turn' if angular else 'per m'}"
