"""What a simulated response owes to its step, and to noise that meets a nonlinearity.

Both are known from further simulations and are no missing physics. A stretch in which they show
counts for less: they join the covariance of noise there, whichever hypothesis is scored.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.hearing.sensed_noise import from_rest, linear_answer
from gmfbo.diagnosis.comparison.noise.places import Levels
from gmfbo.diagnosis.comparison.noise.unseen_input import unseen_input
from gmfbo.diagnosis.comparison.numbers import PLAYED_NOISES
from gmfbo.diagnosis.comparison.port_kernels import PortKernels, through
from gmfbo.diagnosis.comparison.problem import Problem
from gmfbo.diagnosis.comparison.whitener import segment_whitener
from gmfbo.diagnosis.runs.simulated import Point, Simulated
from gmfbo.diagnosis.runs.simulations import Simulations
from gmfbo.diagnosis.runs.start_changes import start_changes

Array = NDArray[np.float64]

Columns = tuple[tuple[Array, ...], ...]

_LINEAR = 0.01  # of its linear answer: less than this noise makes in an axis without friction


@dataclass(frozen=True, eq=False)
class SimulationErrors:
    """Errors of the signals of simulated recordings, each of one standard deviation.

    Attributes
    ----------
    simulations : Simulations
        Of the recordings.
    constant, varying : tuple of tuple of ndarray, shape (k, n)
        [SI] By recording, then by signal at its own times: errors of one size in a recording, and
        those of another size in each stretch.
    between : tuple of tuple of ndarray, shape (k, n)
        [SI] The same of the input of a plant between its rows, one for each.
    spreads : mapping of str to float
        Of own parts of the model's quantities in each recording, which its columns show.
    dither : float
        [standard deviations of rounding] White noise that was rounded with a followed position.
    """

    simulations: Simulations
    constant: Columns
    varying: Columns
    between: Columns = ()
    spreads: Mapping[str, float] = field(default_factory=dict)
    dither: float = 0.0

    def on(self, problem: Problem, fitted: Fitted) -> list[tuple[Array, Array]]:
        """As the logger stores them, on a problem's segments, each of shape (k, m, n).

        Parameters
        ----------
        problem : Problem
            Of the same recordings, or of some windows of them; others have no errors.
        fitted : Fitted
            Signals and errors of the logger about which they are stored.
        """
        varying = self._stored(self.varying, problem, fitted)
        return list(zip(self._constant(problem, fitted), varying, strict=True))

    def as_of(self, other: SimulationErrors) -> SimulationErrors:
        """The same with the own parts of another, and with errors of the input as that has them.

        Parameters
        ----------
        other : SimulationErrors
            Of other recordings, or about another fit.
        """
        between = self.between if other.between else ()
        return replace(self, between=between, spreads=other.spreads, dither=other.dither)

    @property
    def of_rows(self) -> SimulationErrors:
        """Those of what rows leave open alone: an input between them, and slow rounding."""
        nothing = tuple(tuple(columns[:0] for columns in own) for own in self.constant)
        return replace(self, constant=nothing, varying=nothing, spreads={})

    def _constant(self, problem: Problem, fitted: Fitted) -> list[Array]:
        """Errors of one size in a recording, by segment."""
        parts = (
            self._stored(self.constant, problem, fitted),
            problem.slow_rounding(self.dither),
            self._of_input(problem),
        )
        return [np.concatenate(errors) for errors in zip(*parts, strict=True)]

    def _of_input(self, problem: Problem) -> list[Array]:
        """What an input between its rows made, by segment."""
        known = bool(self.between) and problem.simulations is self.simulations
        found = []
        for segment in problem.segments:
            columns = self.between[segment.record] if known else ()
            errors = [segment.read(one) for one in zip(*columns, strict=True)]
            found.append(
                np.array(errors).reshape(len(errors), len(segment.names), segment.time.size)
            )
        return found

    def _stored(self, columns: Columns, problem: Problem, fitted: Fitted) -> list[Array]:
        logging, nuisances = problem.logging, fitted.nuisances
        found = []
        for segment, values in zip(problem.segments, fitted.values, strict=True):
            own = columns[segment.record] if problem.simulations is self.simulations else ()
            errors = [segment.read(one) for one in zip(*own, strict=True)]
            seen = logging.seen(segment, values, nuisances) if errors else values
            made = [logging.seen(segment, values + error, nuisances) - seen for error in errors]
            found.append(np.array(made).reshape(len(made), *values.shape))
        return found

    def _own(self, fitted: Fitted) -> list[Array]:
        """What own parts of one standard deviation make, by segment, shape (k, m, n)."""
        names = fitted.hypothesis.names
        sizes = {i: self.spreads[n] for i, n in enumerate(names) if n in self.spreads}
        each = np.array(list(sizes.values()))[:, None, None]
        return [columns[list(sizes)] * each for columns in fitted.columns]

    def taken_out(
        self, problem: Problem, fitted: Fitted, kernels: PortKernels, levels: Levels
    ) -> Fitted:
        """A fit whose residual lacks what the constant errors most likely made of it.

        Those that vary are as many in each stretch as would take noise with them.

        Parameters
        ----------
        problem : Problem
            Of the same recordings.
        fitted : Fitted
            Its residual.
        kernels : PortKernels
            Paths of noise.
        levels : Levels
            Of the noise beside them.
        """
        constant = self._constant(problem, fitted)
        if self.spreads and fitted.columns:
            constant = [
                np.concatenate(both) for both in zip(constant, self._own(fitted), strict=True)
            ]
        if not any(len(errors) for errors in constant):
            return fitted
        rates = problem.rates(fitted.values)
        left = []
        for segment, residual, rate, errors in zip(
            problem.segments, fitted.residual, rates, constant, strict=True
        ):
            whitener = segment_whitener(segment, kernels, levels, rate)
            left.append(residual - whitener.mean_of(errors, residual))
        return replace(fitted, residual=left)


def errors_of(
    simulations: Simulations,
    point: Point,
    kernels: PortKernels,
    level: float,
    held: float = 0.0,
    unheard: Callable[[np.random.Generator], list[Array]] | None = None,
) -> SimulationErrors:
    """Measure what a finer step changes, and what noise makes beyond its linear answer.

    Noise that the controller reads lets an axis leave its friction, or a gap, at other instants.
    Its linear answer is in the covariance of the noise already. The rest is drawn, a few
    realisations standing for its covariance (Evensen 2003).

    Parameters
    ----------
    simulations : Simulations
        Of the recordings.
    point : Point
        At which they are measured; the noise that it plays is known.
    kernels : PortKernels
        Paths of noise.
    level : float
        [FMU's unit] Standard deviation of the white noise that the controller reads.
    held : float
        [FMU's unit] Torque that friction may hold at rest.
    unheard : callable (numpy Generator) -> list of ndarray, shape (rows,)
        [FMU's unit] Draws what is not known of the noise, by recording; all of it by default.
    """
    quiet = replace(point, noise=None)
    runs = simulations.run([quiet])[0]
    known = runs if point.noise is None else simulations.run([point])[0]
    level = kernels.beyond_rounding(level)
    constant: list[Sequence[Sequence[Array] | None]] = [
        simulations.input_errors(quiet, runs),
        *_averaging(simulations, runs),
        *_held(simulations, kernels, held),
        *start_changes(simulations, quiet, runs),
    ]
    found: list[Sequence[Sequence[Array] | None]] = [simulations.step_errors(quiet, runs)]
    if "sensor" in kernels.simulated and level > 0.0:
        rng = np.random.default_rng(0)
        sizes = [record.plan.grid.size for record in simulations.records]

        def drawn() -> list[Array]:
            if unheard is not None:
                return unheard(rng)
            return [from_rest(level * rng.standard_normal(n)) for n in sizes]

        played = _played(simulations, point, known, kernels, [drawn()])
        if not all(_is_linear(one) for one in played[0]):
            others = [drawn() for _ in range(PLAYED_NOISES - 1)]
            found += _errors([*played, *_played(simulations, point, known, kernels, others)])
    return SimulationErrors(
        simulations,
        _by_recording(simulations, constant),
        _by_recording(simulations, found),
        _between_rows(simulations, kernels),
    )


def _between_rows(simulations: Simulations, kernels: PortKernels) -> Columns:
    """What the input of a plant may have done between its rows; empty where that is known."""
    made = [unseen_input(record, kernels.of(k)) for k, record in enumerate(simulations.records)]
    if all(one is None for one in made):
        return ()
    return tuple(
        tuple(np.zeros((0, s.time.size)) for s in record.signals) if one is None else one
        for one, record in zip(made, simulations.records, strict=True)
    )


def _by_recording(
    simulations: Simulations, errors: Sequence[Sequence[Sequence[Array] | None]]
) -> Columns:
    """Errors by recording and signal, without those that could not be simulated."""
    columns = []
    for k, record in enumerate(simulations.records):
        own = [error[k] for error in errors if error[k] is not None]
        shapes = [signal.time.size for signal in record.signals]
        columns.append(
            tuple(
                np.array([error[i] for error in own if error is not None]).reshape(len(own), n)
                for i, n in enumerate(shapes)
            )
        )
    return tuple(columns)


def _averaging(
    simulations: Simulations, runs: Sequence[Simulated]
) -> list[list[tuple[Array, ...] | None]]:
    """Change of each signal by a logger that stores its mean over a row, for each by itself.

    A drive's trace often averages the samples of a faster controller, which delays the column by
    half a row and spreads what the command does at a step of its reference. Where the plant runs on
    the recorded command, that column is averaged as well, and nothing is late.
    """
    if simulations.tracking is not None:
        return []
    names = dict.fromkeys(s.name for record in simulations.records for s in record.signals)
    found: list[list[tuple[Array, ...] | None]] = []
    for name in names:
        own: list[tuple[Array, ...] | None] = []
        for k, run in enumerate(runs):
            means = simulations.averaged(run, k) if run.finite else run.signals
            signals = zip(simulations.records[k].signals, means, run.signals, strict=True)
            own.append(tuple((m - v) * (s.name == name) for s, m, v in signals))
        found.append(own)
    return found


def _held(
    simulations: Simulations, kernels: PortKernels, torque: float
) -> list[list[tuple[Array, ...] | None]]:
    """What a torque that friction holds in a long rest makes of the signals, for each by itself.

    It goes as the motion begins. How it came depends on a past that nobody recorded.
    """
    if "torque" not in kernels.simulated or torque <= 0.0:
        return []
    most = max(len(record.rests) for record in simulations.records)
    return [
        [
            _of_rest(simulations, kernels, k, j, torque) if j < len(record.rests) else None
            for k, record in enumerate(simulations.records)
        ]
        for j in range(most)
    ]


def _of_rest(
    simulations: Simulations, kernels: PortKernels, k: int, j: int, torque: float
) -> tuple[Array, ...]:
    record, paths = simulations.records[k], kernels.of(k).simulated["torque"]
    grid, (start, end) = record.plan.grid, record.rests[j]
    taps = next(iter(paths.values())).size
    acts = np.concatenate([np.zeros(taps), torque * ((grid >= start) & (grid <= end))])
    acts[:taps] = acts[taps]  # before the recording began, too
    return tuple(
        np.interp(signal.time, grid, through(acts, paths[signal.name])[taps:])
        for signal in record.signals
    )


@dataclass(frozen=True, eq=False)
class _Heard:
    """What noise makes of the signals of a recording: by a linear path, and beyond it [SI]."""

    linear: tuple[Array, ...]
    beyond: list[Array]


def _is_linear(heard: _Heard | None) -> bool:
    """Whether noise makes nothing worth a further simulation, beyond its linear answer."""
    return heard is None or all(
        float(np.std(beyond)) <= _LINEAR * float(np.std(linear))
        for linear, beyond in zip(heard.linear, heard.beyond, strict=True)
    )


def _errors(played: Sequence[Sequence[_Heard | None]]) -> list[list[list[Array] | None]]:
    size = np.sqrt(PLAYED_NOISES)
    return [
        [None if one is None else [beyond / size for beyond in one.beyond] for one in own]
        for own in played
    ]


def _played(
    simulations: Simulations,
    point: Point,
    runs: list[Simulated],
    kernels: PortKernels,
    drawn: Sequence[Sequence[Array]],
) -> list[list[_Heard | None]]:
    """Each realisation of noise in each recording."""
    orders = [(own[k], k) for own in drawn for k in range(len(runs))]
    heard = simulations.map(
        lambda order: _beyond_linear(simulations, point, runs, kernels, *order), orders
    )
    return [heard[i : i + len(runs)] for i in range(0, len(heard), len(runs))]


def _beyond_linear(
    simulations: Simulations,
    point: Point,
    runs: list[Simulated],
    kernels: PortKernels,
    noise: Array,
    k: int,
) -> _Heard | None:
    """Change of a recording's signals under noise; None where it cannot be simulated."""
    more, linear = kernels.of(k).sensed(noise), linear_answer(simulations, kernels, k, noise)
    if point.noise is None:
        noisy = simulations.run_one(point, k, excitation=more)
    else:
        both = [*point.noise]
        both[k] = replace(both[k], at_port=both[k].at_port + more[both[k].port])
        noisy = simulations.run_one(replace(point, noise=tuple(both)), k)
    if not (noisy.finite and runs[k].finite):
        return None
    signals = zip(runs[k].signals, noisy.signals, linear, strict=True)
    return _Heard(linear, [after - before - own for before, after, own in signals])
