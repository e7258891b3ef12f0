"""Margins of the loop, measured on the twin by a multisine at its command port."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import SimulationError
from gmfbo.objective.margins import UNSTABLE, margins
from gmfbo.recordings.recording import Recording
from gmfbo.recordings.reference import disturbance_signal
from gmfbo.sources.plants.source import Source

COMMAND_PORT = "command"
"""Port at which the loop is excited."""

AMPLITUDES = (0.02, 0.04)
"""RMS of the multisine, as shares of the largest command while the reference is followed: small
enough for the axis not to turn round, and twice that, to see whether the size matters."""

LINES = 60
"""Most frequencies, evenly spaced in their logarithm; about twenty a decade."""

FINER = 10
"""Steps of the twin within its communication step, so that a continuous controller's command is
read late by no more than a tenth of a step."""

_PERIODS = 3  # the first is left out: the axis starts to move in it
_APART = 0.5  # of two periods, beyond which the loop does not settle into the multisine


@dataclass(frozen=True)
class LoopMargins:
    """Margins at some gains.

    Attributes
    ----------
    values : mapping of str to float
        The worse of both amplitudes: phase_margin [deg], gain_margin and ms as factors.
    amplitudes : tuple of float
        RMS of the two multisines [unit of the command].
    each : tuple of mapping of str to float
        Margins at each amplitude.
    """

    values: Mapping[str, float]
    amplitudes: tuple[float, ...]
    each: tuple[Mapping[str, float], ...]


@dataclass(frozen=True, eq=False)
class MarginMeter:
    """Measures margins of the loop on a twin.

    The reference moves on steadily, so that friction acts one way, while a multisine is added to
    the command. With D the multisine and U the controller's answer at a frequency, the loop is
    L = -U / (U + D); where the twin's command holds the multisine already, L = (D - U) / U.

    Attributes
    ----------
    twin : Source
        Twin whose command port a recording drives, stepped finely.
    coarse : Source
        The same at its own step, for FMUs that refuse a finer one.
    reference : Recording
        What the study follows; it gives size and length of the motion.
    command : str
        Signal of the command.
    horizon : float
        [s] Period of the multisine: the scored length of the reference.
    step : float
        [s] Communication step of the twin.
    """

    twin: Source
    coarse: Source
    reference: Recording
    command: str
    horizon: float
    step: float

    def measure(self, gains: Mapping[str, float]) -> LoopMargins:
        """Measure at both amplitudes.

        Parameters
        ----------
        gains : mapping of str to float
            All gains by name [unit of the FMU parameter].

        Raises
        ------
        SimulationError
            The twin has no command to be read, or does not move it.
        """
        followed = self.coarse.run(gains, self.reference)
        if getattr(followed, "status", "ok") != "ok":
            return LoopMargins(UNSTABLE, (), ())
        largest = float(np.nanmax(np.abs(followed.signal(self.command))))
        if not largest > 0.0:
            raise SimulationError(
                f"margins: '{self.command}' of the twin stays zero while the reference is "
                "followed, so that no size of an excitation follows from it"
            )
        sizes = tuple(share * largest for share in AMPLITUDES)
        each = tuple(self._at(gains, size) for size in sizes)
        worst = {
            name: (max if name == "ms" else min)(one[name] for one in each) for name in UNSTABLE
        }
        return LoopMargins(worst, sizes, each)

    def _at(self, gains: Mapping[str, float], amplitude: float) -> dict[str, float]:
        for source, step in ((self.twin, self.step / FINER), (self.coarse, self.step)):
            rows = round(self.horizon / step)
            lines = _lines(rows, round(0.4 * self.horizon / self.step))
            excited = _excitation(rows, lines, amplitude)
            run = source.run(gains, self._moving(np.tile(excited, _PERIODS), step))
            if getattr(run, "status", "ok") == "ok":
                # A row shows the command that was held up to it: row k + 1 belongs to step k.
                answer = run.signal(self.command)[1:]
                return _margins(answer, excited, lines, self.horizon)
        return dict(UNSTABLE)

    def _moving(self, excited: NDArray[np.float64], step: float) -> Recording:
        """A steady motion of the reference's size a period, with the excitation."""
        name, *others = self.reference.signals
        asked = self.reference.signals[name]
        size = float(np.ptp(asked)) or 1.0
        time = np.arange(excited.size + 1, dtype=np.float64) * step
        signals = {name: asked[0] + size * time / self.horizon}
        signals |= {other: np.zeros(time.size) for other in others}
        signals[disturbance_signal(COMMAND_PORT)] = np.append(excited, 0.0)
        return Recording(
            time=time,
            signals=signals,
            units=dict(self.reference.units),
            name="multisine",
            parameters=self.reference.parameters,
        )


def differing(found: LoopMargins) -> list[str]:
    """Margins that differ by more than a tenth between the amplitudes, in words.

    Parameters
    ----------
    found : LoopMargins
        Measured at both amplitudes.
    """
    if len(found.each) < 2:
        return []
    small, large = found.each
    one, two = found.amplitudes
    return [
        f"{name.replace('_', ' ')} {small[name]:.3g} at a multisine of {one:.3g} RMS, "
        f"{large[name]:.3g} at {two:.3g}"
        for name in small
        if abs(small[name] - large[name]) > 0.1 * max(abs(small[name]), abs(large[name]))
    ]


def _lines(rows: int, last: int) -> NDArray[np.int_]:
    """Numbers of the lines, cycles a period, up to 0.4 of the twin's sampling rate."""
    most = max(min(last, rows // 2 - 1), 2)
    return np.unique(np.round(np.geomspace(1, most, LINES)).astype(int))


def _excitation(rows: int, lines: NDArray[np.int_], amplitude: float) -> NDArray[np.float64]:
    """Multisine of equal lines, of low crest by Schroeder's phases (1970), shape (rows,)."""
    place = np.arange(lines.size)
    spectrum = np.zeros(rows // 2 + 1, dtype=complex)
    spectrum[lines] = np.exp(-1j * np.pi * place * (place + 1) / lines.size)
    wave = np.fft.irfft(spectrum, rows)
    return np.asarray(wave * amplitude / np.sqrt(np.mean(wave**2)))


def _margins(
    answer: NDArray[np.float64],
    excited: NDArray[np.float64],
    lines: NDArray[np.int_],
    period: float,
) -> dict[str, float]:
    """Margins from the controller's answer over the last two periods."""
    rows = excited.size
    each = [np.fft.rfft(answer[k * rows : (k + 1) * rows])[lines] for k in range(1, _PERIODS)]
    added = np.fft.rfft(excited)[lines]
    change = np.linalg.norm(each[1] - each[0])
    if not np.isfinite(change) or change > _APART * np.linalg.norm(added):
        return dict(UNSTABLE)
    mean = (each[0] + each[1]) / 2.0
    # At the highest frequencies the loop answers little: what is left there is the multisine.
    included = abs(mean[-1] / added[-1] - 1.0) < abs(mean[-1] / added[-1])
    loop = (added - mean) / mean if included else -mean / (mean + added)
    return margins(lines / period, loop)
