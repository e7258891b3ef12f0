"""What no law holds: a smooth torque over velocity and position, sent through the loop."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from gmfbo.diagnosis.comparison.evidence import Grams, grams, log_evidences
from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.ledger import Ledger
from gmfbo.diagnosis.comparison.numbers import SMOOTH_BUMPS
from gmfbo.diagnosis.comparison.port_kernels import PortKernels, through
from gmfbo.diagnosis.comparison.problem import Problem
from gmfbo.diagnosis.comparison.whitener import Whitening

Array = NDArray[np.float64]

_BUMPS = 10  # over each of velocity and position
_COUNTS = 1e-8  # of the largest variance of a smooth function's parts: less is no part
_STEP = np.log(4.0)  # between sizes of an inadequacy
_SIZES = np.exp(_STEP * np.arange(-5.0, 4.0))  # times the tolerance


def inadequacy_columns(problem: Problem, kernels: PortKernels, fitted: Fitted) -> list[Array]:
    """Signals that unit curves of torque over velocity and over position cause, shape (c, m, n).

    Parameters
    ----------
    problem : Problem
        Recordings.
    kernels : PortKernels
        Answer of the signals to the torque port.
    fitted : Fitted
        Whose velocities and positions are taken.
    """
    if "torque" not in kernels.kernels:
        return [np.zeros((0, len(s.names), s.time.size)) for s in problem.segments]
    motion = motion_of(problem, fitted)
    low, high = ends_of(motion.positions)
    curves = [
        np.concatenate([smooth(speed, -1.0, 1.0), smooth(position, low, high)])
        for speed, position in zip(motion.speeds, motion.positions, strict=True)
    ]
    return through_loop(problem, kernels, "torque", curves)


@dataclass(frozen=True, eq=False)
class Motion:
    """How the axis moves in each simulated recording.

    Attributes
    ----------
    positions, velocities : list of ndarray, shape (rows,)
        [FMU's units]
    speeds : list of ndarray, shape (rows,)
        Signed roots of the velocities, in those of `fast`: finer about standstill, where friction
        changes.
    fast : float
        [FMU's unit of the velocity] That is hardly exceeded.
    """

    positions: list[Array]
    velocities: list[Array]
    speeds: list[Array]
    fast: float


def motion_of(problem: Problem, fitted: Fitted) -> Motion:
    """Positions and velocities of a fit.

    Parameters
    ----------
    problem : Problem
        Recordings.
    fitted : Fitted
        Whose simulated states are taken.
    """
    positions, velocities = [], []
    for record, run in zip(problem.simulations.records, fitted.runs, strict=True):
        positions.append(run.response.states["position"])
        velocity = run.response.states.get("velocity")
        if velocity is None:
            velocity = np.gradient(positions[-1], record.plan.grid)
        velocities.append(velocity)
    fast = float(np.quantile(np.abs(np.concatenate(velocities)), 0.998)) or 1.0
    speeds = [np.sign(v) * np.sqrt(np.abs(v) / fast) for v in velocities]
    return Motion(positions, velocities, speeds, fast)


def ends_of(columns: Sequence[Array]) -> tuple[float, float]:
    """Ends of the range that a state has in all recordings, but for a few rows."""
    low, high = np.quantile(np.concatenate(columns), [0.002, 0.998])
    return float(low), float(high)


def through_loop(
    problem: Problem,
    kernels: PortKernels,
    port: str,
    signals: Sequence[Array],
    *,
    as_simulated: bool = False,
) -> list[Array]:
    """What signals at a port cause, by segment, shape (c, m, n).

    Parameters
    ----------
    problem : Problem
        Recordings.
    kernels : PortKernels
        Answer of the recorded signals to each port.
    port : str
        Where they act.
    signals : sequence of ndarray, shape (c, rows)
        [FMU's unit of the port] By recording, on its grid.
    as_simulated : bool
        Without what the log alone has of them, and as physics that acted before the recording,
        where recordings begin at rest.
    """
    made = []
    simulations = problem.simulations
    is_held = as_simulated and simulations.begins_at_rest and simulations.rest > 0
    for segment in problem.segments:
        grid = problem.simulations.records[segment.record].plan.grid
        answers = kernels.of(segment.record)
        paths = (answers.simulated if as_simulated else answers.kernels)[port]
        own = signals[segment.record]
        before = max(kernel.size for kernel in paths.values()) if is_held else 0
        own = np.concatenate([np.repeat(own[:, :1], before, axis=1), own], axis=1)
        columns = np.zeros((len(own), len(segment.names), segment.time.size))
        for i, name in enumerate(segment.names):
            for c, answer in enumerate(through(own, paths[name])):
                columns[c, i] = np.interp(segment.time, grid, answer[before:])
        made.append(columns)
    return made


def smooth(
    values: Array, low: float, high: float, count: int = _BUMPS, over: float = SMOOTH_BUMPS
) -> Array:
    """Columns whose independent normal amplitudes make a smooth function of about that size.

    Neighbouring bumps rise together (Rasmussen and Williams 2006, eq. 2.16): were they
    independent, a step at standstill would be as likely as any curve, and that is friction.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Of a state.
    low, high : float
        Its range.
    count : int
        Of bumps over the range.
    over : float
        [bumps] Over which it is smooth.

    Returns
    -------
    ndarray, shape (c, n)
        At most `count`: of a smoother function, only the columns that count.
    """
    centres = np.linspace(low, high, count)
    width = max(centres[1] - centres[0], 1e-300)
    bumps = np.exp(-0.5 * ((values - centres[:, None]) / width) ** 2)
    apart = np.arange(count)
    alike = np.exp(-0.5 * ((apart[:, None] - apart) / over) ** 2)
    middle = np.exp(-0.5 * (apart - 0.5 * (count - 1)) ** 2)
    size = np.sqrt(middle @ alike @ middle)
    variances, shapes = np.linalg.eigh(alike)
    counts = variances > _COUNTS * variances[-1]
    factor = shapes[:, counts] * np.sqrt(variances[counts]) / size
    found: Array = factor.T @ bumps
    return found


class BesideInadequacy:
    """Inner products of rows beside an inadequacy, made once while row and whitening stay.

    Parameters
    ----------
    problem : Problem
        Recordings.
    """

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        self._about: tuple[Whitening, PortKernels, Fitted] | None = None
        self._bumps: list[Array] = []
        self._known: WeakKeyDictionary[Fitted, Grams] = WeakKeyDictionary()

    def begin(self, ledger: Ledger) -> int:
        """Number of bumps under the whitening of a ledger, as its first row moves the axis."""
        whitening, kernels = ledger.whitening, ledger.kernels
        first = next(iter(ledger.rows.values()))
        about = (whitening, kernels, first)
        if self._about is None or any(a is not b for a, b in zip(about, self._about, strict=True)):
            self._about, self._known = about, WeakKeyDictionary()
            self._bumps = whitening(inadequacy_columns(self._problem, kernels, first))
        return len(self._bumps[0])

    def grams(self, row: Fitted) -> Grams:
        """Of a row's columns, then of the bumps."""
        assert self._about is not None
        if row not in self._known:
            own = row.beside_own_parts(self._about[0])
            self._known[row] = grams(self._problem, own, row, own.of_own(self._bumps))
        return self._known[row]


def with_inadequacy(
    fitted: Fitted, inner: Grams, weights: Array, extra: int, tolerance: float
) -> tuple[Array, Array]:
    """Log evidence with the size of an inadequacy integrated out, and what is believed of it.

    Its prior is exponential about the tolerance (Simpson et al. 2017).

    Parameters
    ----------
    fitted : Fitted
        A hypothesis at its best values.
    inner : Grams
        Of its columns, then of `extra` bumps orthogonal to them.
    weights : ndarray, shape (n_weightings, n_stretches)
        Of the stretches.
    extra : int
        Number of bumps.
    tolerance : float
        [FMU's unit of the torque port] Mean of the prior of the size.

    Returns
    -------
    tuple of ndarray, shape (n_weightings,)
        [nats], and its mean [FMU's unit of the torque port].
    """
    if not extra:
        return log_evidences(fitted, inner, weights), np.zeros(len(weights))
    sizes = tolerance * _SIZES
    logs = np.stack([log_evidences(fitted, inner, weights, extra, float(s)) for s in sizes])
    prior = np.log(_STEP * sizes / tolerance) - sizes / tolerance
    joint = logs + prior[:, None]
    total = logsumexp(joint, axis=0)
    believed = np.exp(joint - total).T
    return total, believed @ sizes
