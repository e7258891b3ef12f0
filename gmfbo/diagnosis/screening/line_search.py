"""Lines regressed one after the other on what a fitted model leaves.

The scan reads the residual backwards to the port, where each line is one sum; only its peaks are
regressed in full, together with the parameters' sensitivities.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import percentile_filter

from gmfbo.diagnosis.fitting.misfit import Blocks
from gmfbo.diagnosis.fitting.regression import Regression, joined
from gmfbo.diagnosis.screening.line_axes import Axis
from gmfbo.diagnosis.screening.port_response import PortResponse
from gmfbo.diagnosis.screening.seen_from_port import fields, whitened_columns

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Line:
    """A line of the misfit.

    Attributes
    ----------
    place : float
        Wavenumber [rad per position unit] or frequency [Hz].
    gain : float
        Fall of chi2 on what was left out, beyond stronger lines.
    """

    place: float
    gain: float


MOST_LINES = 8

LEAST_GAIN = 25.0
"""Fall of chi2 on what was left out, by which the best of all lines stands out of the noise.

In 80 scans of white residuals the most was 23 and, once, 30.
"""

FAINT = 0.005
"""Share of the strongest line's gain below which others may be its shadow: the response is only
linear."""

_RIVAL = 0.5  # of the better family's gain: then the other is tried as well
_HARDLY = 0.01  # of a line's gain: lost for a whole number of cycles a turn
_FEW_A_TURN = np.arange(1.0, 13.0)
"""[1/rad] Tried in any case: they show in less than a turn (gravity, unbalance, slots), but in a
scan they are wide, and close to what an offset and friction leave."""

_NORMS = 24  # points of the scan at which the size of a line's change is computed
_PEAKS = 6  # of the scan, that are regressed in full
_SURROUNDINGS = 161  # points of the scan around a peak, whose upper quartile it has to exceed
_PROMINENT = 3.0  # times
_CLIMBED = 2  # of those, the best are refined
_REFINED = 4  # rounds of refinement, each to a third of the distance


class LineSearch:
    """Search along one self._axis.

    Parameters
    ----------
    regression : Regression
        Of what a fitted model leaves.
    response : PortResponse
        From the port to the signals.
    axis : Axis
        Where lines may stand.
    """

    def __init__(self, regression: Regression, response: PortResponse, axis: Axis) -> None:
        self._regression, self._response, self._axis = regression, response, axis
        self._known: dict[float, Blocks] = {}
        self._sizes = self._interpolated_sizes()

    @property
    def _lowest(self) -> float:
        """Place below which a line is an offset or a slope to these recordings."""
        lowest = float(self._axis.places[0])
        return min(0.5 * lowest, 0.9) if self._axis.rounded else lowest

    def strongest(self, own: Blocks, least: float, most: int = MOST_LINES) -> list[Line]:
        """Lines found one after the other, each beyond those before it and other columns."""
        found: list[Line] = []
        while len(found) < most:
            with_found = self.with_lines(found, own)
            peaks = _peaks(self._axis.places, self._scan(self._regression.left(with_found)))
            if self._axis.rounded:
                peaks = np.append(peaks, _FEW_A_TURN)
            if not peaks.size:
                break
            gains = self._gains(peaks, with_found)
            best = Line(0.0, 0.0)
            for i in np.argsort(-gains)[:_CLIMBED]:
                line = self._climbed(Line(float(peaks[i]), float(gains[i])), with_found)
                best = max(best, line, key=lambda line: line.gain)
            faint = FAINT * found[0].gain if found else least
            if best.gain < max(faint, LEAST_GAIN):
                break
            excess = self._regression.excess(joined(with_found, self._columns([best.place])))
            if best.gain < LEAST_GAIN * excess:
                break
            found = self._settled([*found, best], own)
            if min(line.gain for line in found) < LEAST_GAIN * excess:
                # Together they explain no more than fewer do.
                found = [line for line in found if line.gain >= LEAST_GAIN * excess]
                break
        return sorted(self._whole(found, own), key=lambda line: -line.gain)

    def beyond(self, better: Blocks, lines: Sequence[Line], best: float) -> list[Line]:
        """Those of the lines that gain beyond the columns of better ones, or as much without.

        Parameters
        ----------
        better : Blocks
            Columns of all that is better.
        lines : sequence of Line
            Of this self._axis.
        best : float
            Gain of the best of the better lines.
        """
        limit = max(LEAST_GAIN * self._regression.excess(better), FAINT * best)
        gains = self._gains([line.place for line in lines], better)
        kept = []
        for line, gain in zip(lines, gains, strict=True):
            if gain > limit:
                kept.append(Line(line.place, float(gain)))
            elif line.gain > _RIVAL * best:
                kept.append(line)
        return kept

    def with_lines(self, lines: Sequence[Line], own: Blocks) -> Blocks:
        """Columns, and those of lines."""
        return joined(own, self._columns([line.place for line in lines])) if lines else own

    def _columns(self, places: Sequence[float] | Array) -> Blocks:
        """Whitened sines, then cosines of lines, none computed twice."""
        keys = [float(place) for place in places]
        new = [key for key in dict.fromkeys(keys) if key not in self._known]
        if new:
            waves = self._axis.waves(np.array(new))
            blocks = whitened_columns(self._regression.misfit, self._response, waves)
            for i, key in enumerate(new):
                self._known[key] = tuple(block[[i, i + len(new)]] for block in blocks)
        found = [self._known[key] for key in keys]
        return tuple(
            np.concatenate([[pair[w][0] for pair in found], [pair[w][1] for pair in found]])
            for w in range(len(found[0]))
        )

    def _gains(self, places: Sequence[float] | Array, own: Blocks) -> Array:
        """Gain of a line at each place alone."""
        count = len(places)
        pairs = [(i, count + i) for i in range(count)]
        return self._regression.gains(own, self._columns(places), pairs)

    def _climbed(self, line: Line, own: Blocks) -> Line:
        """Best place near one."""
        reach = 0.5 * self._axis.resolution
        for _ in range(_REFINED):
            near = line.place + reach * np.array([-1.0, -0.5, 0.5, 1.0])
            near = near[near > self._lowest]
            if not near.size:
                break
            gains = self._gains(near, own)
            i = int(np.argmax(gains))
            if gains[i] > line.gain:
                line = Line(float(near[i]), float(gains[i]))
            reach /= 3.0
        return line

    def _settled(self, lines: list[Line], own: Blocks) -> list[Line]:
        """Move each line to where it is best beside the others: close ones pull each other."""
        if len(lines) == 1:
            return lines
        for i, line in enumerate(lines):
            beside = self.with_lines(lines[:i] + lines[i + 1 :], own)
            start = Line(line.place, float(self._gains([line.place], beside)[0]))
            lines = [*lines[:i], self._climbed(start, beside), *lines[i + 1 :]]
        return lines

    def _whole(self, lines: list[Line], own: Blocks) -> list[Line]:
        """Whole cycles a turn in place of others that are hardly better."""
        if not self._axis.rounded:
            return lines
        for i, line in enumerate(lines):
            beside = self.with_lines(lines[:i] + lines[i + 1 :], own)
            near = float(round(line.place))
            if near <= 0.0 or abs(near - line.place) > self._axis.resolution:
                continue
            here, there = self._gains([line.place, near], beside)
            excess = self._regression.excess(joined(beside, self._columns([line.place])))
            if here - there < max(LEAST_GAIN * excess, _HARDLY * here):
                lines = [*lines[:i], Line(near, float(there)), *lines[i + 1 :]]
        return lines

    def _scan(self, left: Blocks) -> Array:
        """Approximate gain of each place, shape (n_places,)."""
        sums = self._axis.sums(fields(self._regression.misfit, self._response, left))
        scanned: Array = np.abs(sums.sum(axis=0)) ** 2 / self._sizes
        return scanned

    def _interpolated_sizes(self) -> Array:
        """Mean square of a line's whitened change at each place of the scan."""
        n = self._axis.places.size
        chosen = np.unique(np.round(np.geomspace(1, n, _NORMS)).astype(int) - 1)
        places = self._axis.places[chosen]
        blocks = self._columns(places)
        squares = np.sum([np.sum(block**2, axis=-1) for block in blocks], axis=0)
        mean = 0.5 * (squares[: places.size] + squares[places.size :])
        logarithms = np.log(np.maximum(mean, 1e-12 * mean.max()))
        return np.asarray(np.exp(np.interp(self._axis.places, places, logarithms)))


def _peaks(places: Array, values: Array) -> Array:
    """Highest local maxima of a scan that stand out of their surroundings, the tallest in any case.

    What happens at one place only, such as at a reversal, is spread over all wavenumbers alike.
    """
    padded = np.concatenate([[-np.inf], values, [-np.inf]])
    surroundings = percentile_filter(values, 75, min(_SURROUNDINGS, values.size), mode="nearest")
    stands_out = (values > _PROMINENT * surroundings) | (values == values.max())
    local = (values >= padded[:-2]) & (values > padded[2:]) & stands_out
    found = np.flatnonzero(local)
    highest = found[np.argsort(-values[found])][:_PEAKS]
    return np.asarray(places[highest])
