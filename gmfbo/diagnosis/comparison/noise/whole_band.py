"""Levels over the whole band of a residual: what is missing at the ports, and hidden white noise.

What is missing reaches the signals by the ports' paths, which hold where the loop is linear: part
of it may reach each signal by itself. A hundredth of a path is uncertain in any case, so that the
errors of a saturated command, which go no path, fitted a disturbance a hundred times as large
(hobby servo, notebook 03c: 5 V for 0.2 V).

What the controller reads may hide the logger's own noise where levels of noise are read, at high
frequencies, and not below. There it must not be taken for a torque that the twin lacks (development
draw, 072: own noise of the command looked like 2 mN m of torque, in which friction of 6 was lost).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from gmfbo.diagnosis.comparison.noise.places import (
    Levels,
    Periodograms,
    blocks_of,
    split,
    summed,
    with_level,
)
from gmfbo.diagnosis.comparison.numbers import FLOOR, TOLERANCE, TORQUE_TIME
from gmfbo.diagnosis.comparison.port_kernels import PortKernels
from gmfbo.diagnosis.comparison.segments import Segment

Array = NDArray[np.float64]
Spectrum = NDArray[np.complex128]

_STEP = 2.0  # between starts of a level, in its logarithm
_TIMES = 2.0 ** np.arange(-4.0, 3.0)  # of the usual correlation time


def inadequate(
    kernels: PortKernels,
    segments: Sequence[Segment],
    residuals: Sequence[Array],
    rates: Sequence[Array],
    levels: Levels,
    least: Mapping[str, float],
    near: Levels | None = None,
    white_by: Levels | None = None,
) -> Levels:
    """Levels over the whole band: torque and command ports, and white noise hidden at its top.

    Parameters
    ----------
    kernels : PortKernels
        Paths from the ports to the signals.
    segments : sequence of Segment
        Stretches that are compared.
    residuals, rates : sequence of ndarray, shape (m, n)
        [SI], [SI/s] By segment.
    levels : Levels
        Of the white noise at high frequencies: that of the logger is no less, that of the
        controller no more.
    least : mapping of str to float
        [FMU's unit] By port, the level below which nobody cares; of the sensor that of which an
        encoder in the twin is unsure.
    near : Levels, optional
        Where the search begins too.
    white_by : Levels, optional
        By which the residuals were whitened.
    """
    ports = [port for port in least if port in kernels.kernels and port != "sensor"]
    if not ports:
        return levels  # what is missing would be taken for noise of the logger
    # Of one signal alone nobody tells whether what it shows came by the loop's path.
    apart = any(len(segment.names) > 1 for segment in segments)
    cared, rounding = {port: least[port] for port in ports}, least.get("sensor", 0.0)
    free, low, high = _ranges(levels, cared, rounding, apart=apart)
    blocks = blocks_of(segments, residuals, rates, kernels, 0.0, 0, white_by)
    whole = [_binned(group) for group in blocks]
    quiet = np.where([name == "port:sensor" for name in free], high, low)
    own = np.where([name.startswith("own:") for name in free], _STEP, 0.0)
    pushed = np.array(list(_pushed(quiet, free, len(ports))))
    bounds = list(zip(low, high, strict=True))
    given = [quiet + own]
    if near is not None:
        known = [near.of(name) for name in free]
        given.append(np.log(np.clip(known, np.exp(low), np.exp(high))))
    at = partial(_levels_at, levels, whole, free, kernels, pushed, given, bounds)
    times = TORQUE_TIME * _TIMES
    if near is None:
        return min((at(float(time)) for time in times), key=lambda one: one[0])[1]
    return _downhill(at, times, int(np.argmin(np.abs(np.log(times / near.time)))))


def _levels_at(
    levels: Levels,
    whole: Sequence[_Binned],
    free: Sequence[str],
    kernels: PortKernels,
    pushed: Array,
    given: Sequence[Array],
    bounds: Sequence[tuple[float, float]],
    time: float,
) -> tuple[float, Levels]:
    """Deviance and levels at one correlation time."""
    timed = replace(levels, time=time)
    shares = [_Shares.of(group, timed, free, kernels) for group in whole]
    deviances = np.sum([one.deviances(np.exp(2.0 * pushed)) for one in shares], axis=0)
    starts = [pushed[np.argmin(deviances)], *given]
    nll = partial(_deviance, shares)
    tried = [minimize(nll, x, jac=True, method="L-BFGS-B", bounds=bounds) for x in starts]
    found = min(tried, key=lambda one: float(one.fun))
    for name, value in zip(free, np.exp(found.x), strict=True):
        timed = with_level(timed, name, float(value))
    return float(found.fun), timed


def _downhill(at: Callable[[float], tuple[float, Levels]], times: Array, first: int) -> Levels:
    """Levels at the time from which both neighbours are worse, nearest to a first one."""
    found = {first: at(float(times[first]))}
    best = first
    while True:
        for k in {best - 1, best + 1} & set(range(times.size)) - found.keys():
            found[k] = at(float(times[k]))
        lowest = min(found, key=lambda k: found[k][0])
        if lowest == best:
            return found[best][1]
        best = lowest


def _deviance(shares: Sequence[_Shares], x: Array) -> tuple[float, Array]:
    return summed([one.deviance(np.exp(2.0 * x)) for one in shares])


def _pushed(quiet: Array, free: Sequence[str], ports: int) -> Iterator[Array]:
    """Levels at the ports of which one may be near the right ones.

    All of what is missing goes the ports' paths, an eighth of it astray, or all but as little.
    """
    steps = np.arange(0.0, -np.log(TOLERANCE), _STEP)
    astray = [i for i, name in enumerate(free) if name.startswith("astray:")]
    for levels in product(steps, repeat=ports):
        pushed = quiet.copy()
        pushed[:ports] += levels
        yield pushed
        if not astray:
            continue
        for least in (0.0, _STEP):
            split = pushed.copy()
            split[astray] = np.maximum(split[:ports] + least - _STEP, quiet[astray])
            split[:ports] = np.maximum(split[:ports] - least, quiet[:ports])
            yield split


def _ranges(
    levels: Levels, least: Mapping[str, float], rounding: float, *, apart: bool
) -> tuple[list[str], Array, Array]:
    """Places of what is free, as `estimated` names them, and the ends of its log levels."""
    free = [f"port:{port}" for port in least] + [f"own:{name}" for name in levels.own]
    low = np.log([*least.values(), *levels.own.values()])
    # No more is missing at a port than what acts there at most.
    high = low - np.log(TOLERANCE)
    if apart:
        free += [f"astray:{port}" for port in least]
        whole = np.log([*least.values()])
        low = np.append(low, whole + 0.5 * np.log(FLOOR))  # that much is uncertain in any case
        high = np.append(high, whole - np.log(TOLERANCE))
    read = levels.ports.get("sensor", 0.0)
    if read > 0.0:
        free.append("port:sensor")
        low = np.append(low, np.log(min(max(TOLERANCE * read, rounding), read)))
        high = np.append(high, np.log(read))
    return free, low, high


@dataclass(frozen=True, eq=False)
class _Binned:
    """Mean covariance of spectra within narrow bins, and how many lie in each."""

    names: tuple[str, ...]
    frequencies: Array
    counts: Array
    powers: Spectrum
    square_rates: Array
    record: int


def _binned(group: Periodograms) -> _Binned:
    """Bins a tenth wide: a spectrum changes little within them."""
    place = np.floor(np.log(np.maximum(group.frequencies, 1e-12)) / 0.1)
    place[group.frequencies <= 0.0] = -np.inf
    _, which = np.unique(place, return_inverse=True)
    size = int(which.max()) + 1
    counts = np.bincount(which, minlength=size).astype(float)
    middle = np.bincount(which, group.frequencies, size) / counts
    m = len(group.names)
    powers = np.zeros((size, m, m), dtype=np.complex128)
    outer = np.einsum("bfi,bfj->fij", group.spectra, group.spectra.conj())
    np.add.at(powers, which, outer)
    powers /= (counts * len(group.spectra))[:, None, None]
    counts = counts * len(group.spectra)
    rates = group.square_rates.mean(0)
    return _Binned(group.names, middle, counts, powers, rates, group.record)


@dataclass(frozen=True, eq=False)
class _Shares:
    """Covariance of a group as a sum of variances, each times what its place makes."""

    group: _Binned
    constant: Spectrum
    units: Spectrum

    @classmethod
    def of(
        cls, group: _Binned, levels: Levels, free: Sequence[str], kernels: PortKernels
    ) -> _Shares:
        """Split what is free from what stays.

        Parameters
        ----------
        group : _Binned
            Spectra.
        levels : Levels
            Of what stays.
        free : sequence of str
            Places, as of `estimated`.
        kernels : PortKernels
            Paths from the ports to the signals.
        """
        paths = kernels.of(group.record)
        own = split(levels, free, paths, group.names, group.frequencies, group.square_rates)
        return cls(group, *own)

    def deviances(self, variances: Array) -> Array:
        """Whittle's deviance at many variances, shape (k, places)."""
        s = self.constant + np.tensordot(variances, self.units, 1)
        squares = np.einsum("kfij,fji->kf", np.linalg.inv(s), self.group.powers).real
        found: Array = (squares + np.linalg.slogdet(s)[1]) @ self.group.counts
        return found

    def deviance(self, variances: Array) -> tuple[float, Array]:
        """Whittle's deviance and its slopes over the logarithms of the levels."""
        counts, s = self.group.counts, self.constant + np.tensordot(variances, self.units, 1)
        inverse = np.linalg.inv(s)
        left = np.eye(s.shape[1]) - inverse @ self.group.powers
        squares = s.shape[1] - np.einsum("fii->f", left).real
        value = float(np.sum(counts * (squares + np.linalg.slogdet(s)[1])))
        pull = counts[:, None, None] * (left @ inverse)
        slopes = np.einsum("fij,kfji->k", pull, self.units).real
        return value, 2.0 * variances * slopes
