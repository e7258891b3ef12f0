"""Strong lines of a misfit: over position (cogging), over time (a neighbour), and pulses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.misfit import Blocks
from gmfbo.diagnosis.fitting.regression import Regression, joined
from gmfbo.diagnosis.screening.line_axes import over_position, over_time, with_current
from gmfbo.diagnosis.screening.line_search import FAINT, Line, LineSearch
from gmfbo.diagnosis.screening.port_response import PortResponse
from gmfbo.diagnosis.screening.pulses import Pulse, pulse_change, strongest_pulse
from gmfbo.physics import Excitation

_RIPPLE = 2  # lines that grow with the current: one of them has to be the strongest


@dataclass(frozen=True)
class Lines:
    """What repeats, or passes once, in a misfit.

    Attributes
    ----------
    over_position, over_time : tuple of Line
        Strongest first, at most four.
    with_current : tuple of Line
        Over the position, growing with the current; strongest first.
    passing : tuple of Pulse
        Strongest first.
    """

    over_position: tuple[Line, ...]
    over_time: tuple[Line, ...]
    passing: tuple[Pulse, ...]
    with_current: tuple[Line, ...] = ()

    @property
    def gain(self) -> float:
        """Fall of chi2 by all lines together."""
        return _gain(self.over_position) + _gain(self.over_time)

    @property
    def wavenumbers(self) -> tuple[float, ...]:
        """[rad per position unit] As `Excitation` takes them."""
        return tuple(line.place for line in self.over_position)

    @property
    def ripple_wavenumbers(self) -> tuple[float, ...]:
        """[rad per position unit] As `Excitation` takes them."""
        return tuple(line.place for line in self.with_current)

    @property
    def frequencies(self) -> tuple[float, ...]:
        """[Hz] As `Excitation` takes them."""
        return tuple(line.place for line in self.over_time)

    @property
    def pulses(self) -> tuple[tuple[float, float], ...]:
        """(start, duration) [s] as `Excitation` takes them."""
        return tuple((pulse.start, pulse.duration) for pulse in self.passing)

    def within(self, excitation: Excitation) -> Excitation:
        """Let an excitation hold these lines, from which effects start."""
        return replace(
            excitation,
            wavenumbers=self.wavenumbers,
            ripple_wavenumbers=self.ripple_wavenumbers,
            frequencies=self.frequencies,
            pulses=self.pulses,
        )


def find_lines(case: Case, base: Fitted, response: PortResponse) -> Lines:
    """Search what a fitted model leaves for lines and pulses."""
    regression, own = Regression(case.misfit, base), base.sensitivity
    position = over_position(case, base, response)
    searches = _Searches(
        *(
            None if axis is None else LineSearch(regression, response, axis)
            for axis in (position, over_time(case))
        )
    )
    pulse = strongest_pulse(case, regression, response, own)
    found = searches.strongest(own, 0.0)
    if pulse is not None and pulse.gain > found.gain:
        with_pulse = joined(own, pulse_change(case, response, pulse))
        found = searches.strongest(with_pulse, FAINT * pulse.gain)
    elif found.gain:
        pulse = strongest_pulse(case, regression, response, searches.with_lines(found, own))
    ripple = None if position is None else with_current(position, case, base)
    growing: list[Line] = []
    if ripple is not None:
        growing = LineSearch(regression, response, ripple).strongest(own, 0.0, most=_RIPPLE)
    return Lines(
        found.over_position,
        found.over_time,
        () if pulse is None else (pulse,),
        tuple(growing),
    )


@dataclass(frozen=True)
class _Searches:
    """Searches over position and over time; None where nothing can be looked for."""

    position: LineSearch | None
    time: LineSearch | None

    def strongest(self, own: Blocks, least: float) -> Lines:
        """Lines beside columns, that gain at least so much.

        A motion of constant speed shows a line over position as one over time: the better family
        is taken away before the other is asked again.
        """
        spatial = [] if self.position is None else self.position.strongest(own, least)
        temporal = [] if self.time is None else self.time.strongest(own, least)
        if self.position is not None and self.time is not None and spatial and temporal:
            if _gain(spatial) >= _gain(temporal):
                better = self.position.with_lines(spatial, own)
                temporal = self.time.beyond(better, temporal, spatial[0].gain)
            else:
                better = self.time.with_lines(temporal, own)
                spatial = self.position.beyond(better, spatial, temporal[0].gain)
        return Lines(tuple(spatial), tuple(temporal), ())

    def with_lines(self, lines: Lines, own: Blocks) -> Blocks:
        """Columns, and those of all lines."""
        if self.position is not None:
            own = self.position.with_lines(lines.over_position, own)
        if self.time is not None:
            own = self.time.with_lines(lines.over_time, own)
        return own


def _gain(lines: Sequence[Line]) -> float:
    return sum(line.gain for line in lines)
