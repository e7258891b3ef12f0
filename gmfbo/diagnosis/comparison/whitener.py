"""Whitening of all signals together, row by row, so that stretches can be told apart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len

from gmfbo.diagnosis.comparison.noise.places import Levels, covariance
from gmfbo.diagnosis.comparison.noise.unseen_rows import Mixing, UnseenRows
from gmfbo.diagnosis.comparison.numbers import NOISE_FREEDOM
from gmfbo.diagnosis.comparison.port_kernels import PortKernels
from gmfbo.diagnosis.comparison.segments import Segment

Array = NDArray[np.float64]

_UNSEEN_ROWS = 200  # at least, between the end of a segment and its start
_MASKED_ROWS = 20  # at each end, where a filter sees beyond it
UNMASKED = slice(_MASKED_ROWS, -_MASKED_ROWS)
"""Rows of a whitened segment that are more than nothing."""


@dataclass(frozen=True, eq=False)
class Spread:
    """Directions of stretches in which whitened signals vary by more than noise.

    Stretches that lie end to end are taken together; those that are shorter than the longest have
    nothing at their end.

    Attributes
    ----------
    rows : ndarray of int, shape (n_stretches, length)
        Of the stretches.
    inside : ndarray of bool, shape (n_stretches, length)
        Which of them a stretch really has.
    directions : ndarray, shape (n_stretches, m * length, k)
        Orthonormal.
    lost : ndarray, shape (n_stretches, 1, k)
        Share of each that is taken out, so that what is left varies as noise does.
    """

    rows: NDArray[np.intp]
    inside: NDArray[np.bool_]
    directions: Array
    lost: Array

    def take_out(self, white: Array) -> None:
        """Whiten these rows of whitened columns, shape (..., m, n), in place."""
        count, length = self.rows.shape
        signals, n = white.shape[-2:]
        own = white.reshape(-1, n).take(self.rows, axis=1).reshape(-1, signals, count, length)
        # Signal by signal: all of them in one product are a copy of everything more.
        directions = self.directions.reshape(count, signals, length, -1).swapaxes(0, 1)
        amounts = sum(
            own[:, i].swapaxes(0, 1) @ directions[i] for i in range(signals)
        )  # (n_stretches, columns, k)
        amounts = amounts * self.lost
        places = np.flatnonzero(self.inside)
        first, behind = self.rows[0, 0], self.rows[-1][self.inside[-1]][-1] + 1
        for i in range(signals):
            change = (amounts @ directions[i].swapaxes(1, 2)).swapaxes(0, 1)
            kept = change.reshape(-1, count * length).take(places, axis=1)
            white[..., i, first:behind] -= kept.reshape(*white.shape[:-2], behind - first)


@dataclass(frozen=True, eq=False)
class SegmentWhitener:
    """Filters of one segment, one a class of rows with about the same jitter.

    Attributes
    ----------
    filters : tuple of Mixing
        By the inverse Cholesky factors of the covariance.
    log_determinants : ndarray, shape (n,)
        Of the covariance, a row.
    classes : ndarray of int, shape (n,)
        Filter of each row.
    length : int
        Of the transforms.
    unseen : UnseenRows
        Tells what lies between the end and the start.
    spreads : tuple of Spread
        Of errors beside the noise, in the order in which they are taken out.
    scales : ndarray, shape (n,)
        Noise of a row, in units of that of the levels.
    own : tuple of Spread
        Of what a fit's own parts make, taken out last.
    """

    filters: tuple[Mixing, ...]
    log_determinants: Array
    classes: NDArray[np.intp]
    length: int
    unseen: UnseenRows
    spreads: tuple[Spread, ...] = ()
    scales: Array | float = 1.0
    own: tuple[Spread, ...] = ()

    def __call__(self, columns: Array) -> Array:
        """Whitened columns, shape (..., m, n); nothing at the masked ends."""
        out = self._filtered(columns)
        for spread in self.spreads:
            spread.take_out(out)
        out /= self.scales
        for spread in self.own:
            spread.take_out(out)
        return out

    def scaled_to(self, white: Array, stretches: Sequence[slice]) -> SegmentWhitener:
        """The same with more noise in stretches whose residual holds more.

        Quantised readings, a rough track or a busy bus make noise that comes and goes, where a
        law would gain by following it. The levels are those of quiet stretches, so that it is
        never less: a reading that stands still on one count says nothing of its noise.

        Parameters
        ----------
        white : ndarray, shape (m, n)
            Residual of the segment, whitened.
        stretches : sequence of slice
            Rows.
        """
        squares, logs = white**2, self.log_determinants.copy()
        scales = np.ones(white.shape[1])
        for rows in stretches:
            count = np.count_nonzero(squares[:, rows])
            square = (squares[:, rows].sum() + NOISE_FREEDOM) / (count + NOISE_FREEDOM)
            if square > 1.0:
                scales[rows] = np.sqrt(square)
                logs[rows] += np.log(square) * count / (rows.stop - rows.start)
        return replace(self, log_determinants=logs, scales=self.scales * scales)

    def beside(self, errors: Array, stretches: Sequence[slice]) -> SegmentWhitener:
        """The same with errors beside all else, each of which has an own size in each stretch.

        Parameters
        ----------
        errors : ndarray, shape (k, m, n)
            Each of one standard deviation.
        stretches : sequence of slice
            Rows.
        """
        if not len(errors):
            return self
        spread, logs = self._spread_by(errors, stretches)
        return replace(self, log_determinants=logs, spreads=(*self.spreads, spread))

    def beside_own(self, errors: Array) -> SegmentWhitener:
        """The same with errors of one size in the segment beside all else, scales included.

        Parameters
        ----------
        errors : ndarray, shape (k, m, n)
            Each of one standard deviation.
        """
        spread, logs = self._spread_by(errors, [slice(0, errors.shape[2])])
        return replace(self, log_determinants=logs, own=(*self.own, spread))

    def _spread_by(self, errors: Array, stretches: Sequence[slice]) -> tuple[Spread, Array]:
        """What errors beside all else spread, and the log determinants with them."""
        white, logs = self(errors), self.log_determinants.copy()
        rows, inside = _together(stretches)
        own = np.moveaxis(white[:, :, rows] * inside, 2, 0)  # (n_stretches, k, m, length)
        flat = own.reshape(*own.shape[:2], -1).swapaxes(1, 2)
        directions, sizes, _ = np.linalg.svd(flat, full_matrices=False)
        lost = 1.0 - 1.0 / np.sqrt(1.0 + sizes[:, None, :] ** 2)
        for one, size in zip(stretches, sizes, strict=True):
            logs[one] += np.log1p(size**2).sum() / (one.stop - one.start)
        return Spread(rows, inside, directions, lost), logs

    def mean_of(self, errors: Array, residual: Array) -> Array:
        """What errors beside the noise most likely made of a residual, shape (m, n).

        Parameters
        ----------
        errors : ndarray, shape (k, m, n)
            Each of one standard deviation, of one size in the segment.
        residual : ndarray, shape (m, n)
            [SI] Of the segment.
        """
        if not len(errors):
            return np.zeros(residual.shape)
        flat = self._filtered(errors).reshape(len(errors), -1)
        precision = np.eye(len(errors)) + flat @ flat.T
        sizes = np.linalg.solve(precision, flat @ self._filtered(residual).ravel())
        made: Array = np.tensordot(sizes, errors, axes=1)
        return made

    def _filtered(self, columns: Array) -> Array:
        n = columns.shape[-1]
        spectrum = self.unseen.whole(columns)
        first, *others = self.filters
        out: Array = irfft(first(spectrum), self.length, axis=-1)[..., :n]
        for c, factor in enumerate(others, 1):
            rows = self.classes == c
            out[..., rows] = irfft(factor(spectrum), self.length, axis=-1)[..., :n][..., rows]
        out[..., :_MASKED_ROWS] = 0.0
        out[..., n - _MASKED_ROWS :] = 0.0
        return out


def _together(stretches: Sequence[slice]) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
    """Rows of stretches, shape (n_stretches, length), and which of them each really has."""
    starts = np.array([rows.start for rows in stretches])[:, None]
    ends = np.array([rows.stop for rows in stretches])[:, None]
    rows = starts + np.arange(int(np.max(ends - starts)))
    inside = rows < ends
    return np.where(inside, rows, starts), inside


def segment_whitener(
    segment: Segment, kernels: PortKernels, levels: Levels, rates: Array
) -> SegmentWhitener:
    """Make the filters of a segment.

    Parameters
    ----------
    segment : Segment
        Stretch that is compared.
    kernels : PortKernels
        Paths of noise.
    levels : Levels
        Of the noise.
    rates : ndarray, shape (m, n)
        [SI/s] Of the signals that jitter shows in; 0 for others.
    """
    n, kernels = rates.shape[1], kernels.of(segment.record)
    length = next_fast_len(n + _UNSEEN_ROWS, real=False)
    frequencies = np.arange(length // 2 + 1) / (length * segment.spacing)
    squares = rates**2
    shown = levels.jitter**2 * squares.sum(0)
    quiet = sum(
        levels.own[name] ** 2 for name, r in zip(segment.names, squares, strict=True) if r.any()
    )
    if shown.max() > 0.3 * quiet:
        classes = np.digitize(shown / shown.max(), 4.0 ** np.arange(-7.0, 0.0))
    else:
        classes = np.zeros(n, dtype=np.intp)
    filters: list[Mixing] = []
    logs = np.zeros(n)
    weights = np.full(frequencies.size, 2.0)
    weights[0] = 1.0
    if length % 2 == 0:
        weights[-1] = 1.0
    numbers = np.unique(classes)
    for number in numbers:
        rows = classes == number
        s = covariance(levels, kernels, segment.names, frequencies, squares[:, rows].mean(1))
        factor = np.linalg.cholesky(s)
        filters.append(Mixing.by(np.linalg.inv(factor).astype(np.complex128)))
        log = 2.0 * np.log(np.einsum("fii->fi", factor).real).sum(1)
        logs[rows] = float(weights @ log) / length
    logs[:_MASKED_ROWS] = 0.0
    logs[n - _MASKED_ROWS :] = 0.0
    if len(numbers) > 1:
        s = covariance(levels, kernels, segment.names, frequencies, squares.mean(1))
    return SegmentWhitener(
        tuple(filters),
        logs,
        np.searchsorted(numbers, classes).astype(np.intp),
        length,
        UnseenRows.of(s, length, n),
    )


@dataclass(frozen=True, eq=False)
class Whitening:
    """Whitening of all segments.

    Attributes
    ----------
    parts : tuple of SegmentWhitener
        One a segment.
    spreads : mapping of str to float
        By quantity of a hypothesis, of its own part in each segment; 0 of others.
    """

    parts: tuple[SegmentWhitener, ...]
    spreads: Mapping[str, float] = field(default_factory=dict)

    def scaled_to(self, white: Sequence[Array], stretches: Sequence[Sequence[slice]]) -> Whitening:
        """The same with more noise in stretches whose whitened residual holds more, by segment."""
        parts = zip(self.parts, white, stretches, strict=True)
        scaled = tuple(part.scaled_to(left, rows) for part, left, rows in parts)
        return replace(self, parts=scaled)

    def about(self, names: Sequence[str], columns: Sequence[Array]) -> Whitening:
        """The same with own parts of some quantities beside, each as its column shows it.

        Parameters
        ----------
        names : sequence of str, length p
            Quantities.
        columns : sequence of ndarray, shape (p or more, m, n)
            [SI] Change of the signals of each segment per unit of each; without any, nothing
            changes.
        """
        places = [i for i, name in enumerate(names) if self.spreads.get(name, 0.0) > 0.0]
        if not places or not len(columns):
            return self
        sizes = np.array([self.spreads[names[i]] for i in places])[:, None, None]
        pairs = zip(self.parts, columns, strict=True)
        return Whitening(tuple(part.beside_own(c[places] * sizes) for part, c in pairs))

    def of_own(self, white: Sequence[Array]) -> list[Array]:
        """Take out own parts of columns that are whitened by all else, shape (..., m, n)."""
        found = [np.array(c) if part.own else c for part, c in zip(self.parts, white, strict=True)]
        for part, columns in zip(self.parts, found, strict=True):
            for spread in part.own:
                spread.take_out(columns)
        return found

    @property
    def by_noise(self) -> Whitening:
        """The same without errors beside the noise, which reach from one stretch into others."""
        return Whitening(tuple(replace(part, spreads=(), own=()) for part in self.parts))

    def __call__(self, columns: Sequence[Array]) -> list[Array]:
        """Whiten columns of each segment, shape (..., m, n)."""
        return [part(c) for part, c in zip(self.parts, columns, strict=True)]

    def square(self, columns: Sequence[Array]) -> float:
        """Sum of the squares of whitened signals of each segment, shape (m, n)."""
        return sum(float(np.sum(z**2)) for z in self(columns))

    @property
    def log_determinants(self) -> list[Array]:
        """A row of each segment."""
        return [part.log_determinants for part in self.parts]
