"""Levels of white noise, read in blocks of a residual above a share of the Nyquist frequency."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from gmfbo.diagnosis.comparison.noise.places import (
    Levels,
    Periodograms,
    coloured,
    split,
    summed,
    with_level,
)
from gmfbo.diagnosis.comparison.numbers import TORQUE_TIME
from gmfbo.diagnosis.comparison.port_kernels import PortKernels

Array = NDArray[np.float64]
Spectrum = NDArray[np.complex128]
Judge = Callable[[Array, float], tuple[float, Array, float]]
"""Value of blocks' whitened squares and log determinant, and its slopes by each."""


def estimated(
    kernels: PortKernels,
    periodograms: Sequence[Periodograms],
    least: Levels,
    free: Sequence[str],
    near: Levels | None = None,
) -> Levels:
    """Levels of greatest likelihood: robust first, then without blocks that hold more than noise.

    Parameters
    ----------
    kernels : PortKernels
        Paths from the ports to the signals.
    periodograms : sequence of Periodograms
        Of what a fit leaves.
    least : Levels
        Below which no level is looked for.
    free : sequence of str
        What is estimated: `port:NAME`, `own:SIGNAL`, `jitter`; the others stay as in `least`.
    near : Levels, optional
        Where the search begins; without it several starts are tried.
    """
    low = np.log([least.of(name) for name in free])
    groups = [BlockGroup.of(one, least, free, kernels) for one in periodograms]

    def robust(x: Array) -> tuple[float, Array]:
        return summed([group.judged(np.exp(2.0 * x), group.robust) for group in groups])

    bounds = [(a, a + 25.0) for a in low]
    if near is None:
        starts = _starts(free, low, kernels, periodograms)
        begin = min((np.array(c) for c in product(*starts)), key=lambda x: robust(x)[0])
        x = minimize(robust, begin, jac=True, method="L-BFGS-B", bounds=bounds).x
    else:
        x = np.log([near.of(name) for name in free])
    for most in (2.0, 1.6, 1.6) if near is None else (1.6, 1.6):
        quiet = [group.only(rows) for group, rows in _quiet(groups, np.exp(2.0 * x), most)]

        def nll(x: Array, quiet: list[BlockGroup] = quiet) -> tuple[float, Array]:
            return summed([group.judged(np.exp(2.0 * x), whittle) for group in quiet])

        x = minimize(nll, x, jac=True, method="L-BFGS-B", bounds=bounds).x
    levels = least
    for name, value in zip(free, np.exp(x), strict=True):
        levels = with_level(levels, name, float(value))
    return levels


def whittle(squares: Array, logs: float) -> tuple[float, Array, float]:
    """Deviance of complex normal spectra (Whittle 1953), and its slopes.

    Parameters
    ----------
    squares : ndarray, shape (n_blocks,)
        Of the whitened spectra.
    logs : float
        Log determinant of their covariance.
    """
    return float(squares.sum()) + squares.size * logs, np.ones(squares.size), float(squares.size)


@dataclass(frozen=True, eq=False)
class _Blocks:
    """Blocks of about the same rate, and their covariance as a sum over free places."""

    spectra: Spectrum
    constant: Spectrum
    units: Spectrum

    def whitened(self, variances: Array) -> tuple[Spectrum, Spectrum, Array, float]:
        """Inverse covariance, what it makes of the spectra, their squares, log determinant."""
        s: Spectrum = self.constant + np.tensordot(variances, self.units, 1)
        inverse = np.linalg.inv(s).astype(np.complex128, copy=False)
        x = self.spectra.transpose(1, 2, 0)
        y = inverse @ x
        squares: Array = np.sum(x.real * y.real + x.imag * y.imag, axis=(0, 1))
        return inverse, y, squares, float(np.linalg.slogdet(s)[1].sum())

    def judged(self, variances: Array, judge: Judge) -> tuple[float, Array]:
        """A value, and its slopes over the logarithms of the levels."""
        inverse, y, squares, logs = self.whitened(variances)
        value, by_square, by_logs = judge(squares, logs)
        pull = by_logs * inverse - (y * by_square) @ y.conj().transpose(0, 2, 1)
        slopes = np.einsum("fij,kfji->k", pull, self.units).real
        return value, 2.0 * variances * slopes


@dataclass(frozen=True, eq=False)
class BlockGroup:
    """Blocks of signals with the same names, by their rates."""

    key: tuple[tuple[str, ...], int]
    parts: tuple[_Blocks, ...]

    @classmethod
    def of(
        cls, group: Periodograms, least: Levels, free: Sequence[str], kernels: PortKernels
    ) -> BlockGroup:
        """Split the covariance of blocks.

        Parameters
        ----------
        group : Periodograms
            The blocks.
        least : Levels
            Holds what is not free.
        free : sequence of str
            Places, as `estimated` names them.
        kernels : PortKernels
            Paths from the ports to the signals.
        """
        paths, parts = kernels.of(group.record), []
        for rows in group.alike(least):
            rates = group.square_rates[rows].mean(0)
            own = split(least, free, paths, group.names, group.frequencies, rates)
            parts.append(_Blocks(group.spectra[rows], *own))
        return cls((group.names, group.frequencies.size), tuple(parts))

    def robust(self, squares: Array, logs: float) -> tuple[float, Array, float]:
        """Deviance of Student's t, of which a block that holds more than noise has little say."""
        values = 1.0 + len(self.key[0]) * self.key[1]
        value = float(np.sum(values * np.log1p(squares))) + squares.size * logs
        return value, values / (1.0 + squares), float(squares.size)

    def judged(self, variances: Array, judge: Judge) -> tuple[float, Array]:
        """A value of all blocks, and its slopes over the logarithms of the levels.

        Parameters
        ----------
        variances : ndarray, shape (n_free,)
            Squares of the levels.
        judge : callable (squares, logs)
            Such as `whittle` or `robust`.
        """
        return summed([part.judged(variances, judge) for part in self.parts])

    def squares(self, variances: Array) -> list[Array]:
        """Of the whitened spectra of each block, by part."""
        return [part.whitened(variances)[2] for part in self.parts]

    def only(self, rows: Sequence[NDArray[np.bool_]]) -> BlockGroup:
        """Some of the blocks of each part."""
        parts = zip(self.parts, rows, strict=True)
        kept = (_Blocks(p.spectra[own], p.constant, p.units) for p, own in parts if own.any())
        return BlockGroup(self.key, tuple(kept))


def _starts(
    free: Sequence[str], low: Array, kernels: PortKernels, periodograms: Sequence[Periodograms]
) -> list[list[float]]:
    """Two starts of each level: about all of a residual, and a twentieth of it."""
    found = []
    for name, least in zip(free, low, strict=True):
        largest = float(np.log(_largest(name, kernels, periodograms)))
        found.append([max(float(least), largest - step) for step in (0.7, 3.0)])
    return found


def _quiet(
    groups: Sequence[BlockGroup], variances: Array, most: float
) -> list[tuple[BlockGroup, list[NDArray[np.bool_]]]]:
    """Blocks that hold no more than noise, among all of as many values, whatever their gains."""
    squares = [group.squares(variances) for group in groups]
    alike: dict[tuple[object, ...], list[Array]] = {}
    for group, own in zip(groups, squares, strict=True):
        alike.setdefault(group.key, []).extend(own)
    usual = {key: np.median(np.concatenate(found)) for key, found in alike.items()}
    return [
        (group, [part < most * usual[group.key] for part in own])
        for group, own in zip(groups, squares, strict=True)
    ]


def _largest(name: str, kernels: PortKernels, periodograms: Sequence[Periodograms]) -> float:
    """Level at which one place alone would make all of the residual of its best signal."""
    found = []
    kind, _, which = name.partition(":")
    for group in periodograms:
        power = np.median(np.abs(group.spectra) ** 2, axis=(0, 1)) / np.log(2.0)
        if kind == "own" and which in group.names:
            found.append(np.sqrt(power[group.names.index(which)]))
        elif kind == "port":
            paths = kernels.of(group.record)
            answer = np.abs(paths.spectra(which, group.names, group.frequencies)) ** 2
            colour = (
                1.0 if which == "sensor" else coloured(group.frequencies, paths.step, TORQUE_TIME)
            )
            unit = np.mean(answer * colour, axis=1)
            found.append(np.sqrt(np.min(power / np.maximum(unit, 1e-300))))
        elif kind == "jitter":
            rate = group.square_rates.mean(0)
            shown = rate > 0.0
            if shown.any():
                found.append(np.sqrt(np.min(power[shown] / rate[shown])))
    return float(max(found, default=1e-12)) or 1e-12
