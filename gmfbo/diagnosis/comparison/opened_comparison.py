"""State the comparison of an opened case: stretches, elements, least levels, paths of noise."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.case.command_signal import command_of
from gmfbo.diagnosis.comparison.controller_reading import (
    Controller,
    controllers_of,
    with_reading,
)
from gmfbo.diagnosis.comparison.fit_noise import FitNoise
from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.ledger import Ledger, Scored
from gmfbo.diagnosis.comparison.modes.trial_points import TrialPoints
from gmfbo.diagnosis.comparison.moves import Element, ranked, responses
from gmfbo.diagnosis.comparison.noise.places import Levels
from gmfbo.diagnosis.comparison.nuisance_columns import logging_of
from gmfbo.diagnosis.comparison.numbers import (
    INADEQUACY_TOLERANCE,
    LEAST_GAIN,
    SIZE_SHARE,
    STRETCH_LOOP_TIMES,
    TOLERANCE,
    TORQUE_TIME,
)
from gmfbo.diagnosis.comparison.port_kernels import PortKernels, port_kernels
from gmfbo.diagnosis.comparison.priors import coordinates_of, priors_of
from gmfbo.diagnosis.comparison.problem import EncoderCounts, Problem
from gmfbo.diagnosis.comparison.search import Search
from gmfbo.diagnosis.comparison.segments import segments_of
from gmfbo.diagnosis.comparison.starting.encoder_counts import encoder_counts
from gmfbo.diagnosis.comparison.starting.fixed_parameters import fixed_parameters
from gmfbo.diagnosis.comparison.starting.pointed_starts import pointed_starts
from gmfbo.diagnosis.fitting.hypothesis import Candidate, Hypothesis
from gmfbo.diagnosis.scoring.whitening import Window
from gmfbo.diagnosis.scoring.windows import SETTLING
from gmfbo.diagnosis.screening.testable_effects import candidates

_MOST_STRETCHES = 200
_LEAST_OWN, _LEAST_OWN_POSITION = 5e-4, 1e-6  # of a signal's range
_LEAST_ROUNDING = 0.1  # of a resolution: a reading may be rounded before the controller reads it
_LEAST_JITTER_S = 1e-7
_FOLLOWED = 0.02  # of a position's least noise, where the twin follows it
_FAINT = 1e-3  # of a position's least noise, that the controller reads of it
_LEAST_SI = 1e-12  # [SI] of a column that never changes
_COMMAND_SHARE = 0.3  # rms of a command, of its largest value, where none is simulated


@dataclass(frozen=True, eq=False)
class Comparison:
    """A stated comparison and where it begins.

    Attributes
    ----------
    search : Search
        Over the library and the fixed parameters.
    first : Fitted
        The twin as the case fitted it.
    """

    search: Search
    first: Fitted

    def run(self) -> tuple[Ledger, Scored]:
        """Fit and score hypotheses."""
        ledger = self.search.opened(self.first)
        self._begin(ledger)
        search = self.search
        pointed = pointed_starts(search.problem, ledger, search.elements)
        return replace(search, elements=(*search.elements, *pointed)).searched(ledger)

    def _begin(self, ledger: Ledger) -> None:
        """Let the recordings begin in the way in which forces at rest explain more of them.

        A recording of a real axis begins where axis and controller have come to rest under all
        that acts. A simulated one may begin with the twin's own start, and a force then sets the
        axis in motion. Taken the wrong way, a force leaves a start-up that never was.
        """
        simulations = self.search.problem.simulations
        pushing = [
            e
            for e in self.search.elements
            if e.candidate is not None and e.candidate.law.acts_at_rest
        ]
        if not simulations.rest or not pushing:
            return
        base, gains = ledger.rows[frozenset()], {}
        # What the twin lacks is no noise yet: beside it a start-up would hardly count.
        whitening = self.search.noise.cared_about(base, ledger)
        for at_rest in (True, False):
            simulations.begins_at_rest = at_rest
            found = responses(self.search.problem, base, pushing)
            moves = ranked(whitening, base, found)
            gains[at_rest] = moves[0].gain if moves else 0.0
        simulations.begins_at_rest = gains[False] <= gains[True] + LEAST_GAIN


def comparison_of(
    case: Case,
    effects: Collection[str],
    passing: Sequence[Candidate] = (),
    *,
    held: Collection[str] = (),
    log: Callable[[str], None] = lambda line: None,
) -> Comparison:
    """State the comparison of a case.

    Parameters
    ----------
    case : Case
        Twin and recordings; its setting knows the lines to look for, its simulators stay open.
    effects : collection of str
        Of the catalogue, those that compete.
    passing : sequence of Candidate
        Disturbances that passed once, as a search found them.
    held : collection of str
        FMU parameters that nobody may doubt, beside those under `[fixed]`.
    log : callable (str)
        Told what happens.
    """
    encoder = encoder_counts(case)
    problem = problem_on(case, case.budget.windows, encoder)
    rig = case.rig
    is_open = case.simulations.tracking is not None
    kernels_at, sizes = kernels_of(case, problem), _sizes(case)
    first = _first(case, problem)
    kernels = kernels_at(first)
    problem = replace(problem, is_counted=kernels.is_counted)
    ports = {*first.runs[0].response.ports, *kernels.kernels}
    if is_open and rig.position is not None:
        problem = _followed(case, problem, kernels)
    cared = {p: TOLERANCE * size for p, size in sizes.items() if p != "sensor" and p in ports}
    search = Search(
        _elements(case, effects, passing, held if encoder is None else {*held, *encoder.values}),
        FitNoise(problem, _least_levels(case, problem, ports), cared, held_at_rest(case)),
        INADEQUACY_TOLERANCE * _usual_torque(case),
        kernels_at,
        log,
    )
    return Comparison(search, first)


def held_at_rest(case: Case) -> float:
    """[FMU's unit] Torque that friction may hold at rest: a usual size of a law."""
    return SIZE_SHARE * case.setting.excitation.torque


def _sizes(case: Case) -> dict[str, float]:
    """[FMU's unit] What counts as large, by port."""
    excitation = case.setting.excitation
    return {
        "sensor": excitation.stroke,
        "torque": excitation.torque,
        "command": excitation.command,
    }


def kernels_of(case: Case, problem: Problem) -> Callable[[Fitted], PortKernels]:
    """Measure the paths of noise about a fit, of whose effects only linear ones stay.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    problem : Problem
        Of the same recordings.
    """
    rig, sizes = case.rig, _sizes(case)

    is_open = case.simulations.tracking is not None
    told: list[Sequence[Controller] | None] = []

    @lru_cache(maxsize=1)  # the search begins at the row about which its ports are known
    def kernels_at(fitted: Fitted) -> PortKernels:
        linear = tuple(c for c in fitted.hypothesis.effects if c.law.is_linear)
        hypothesis = Hypothesis(fitted.hypothesis.setting, linear)
        point = problem.point(hypothesis, hypothesis.start(fitted.parameters))
        command = command_of(case)
        rounded = 0.0 if problem.encoder is None else problem.encoder.count
        found = port_kernels(
            case.simulations, point, sizes, rig.position, rig.position_to_si, command, rounded
        )
        if is_open or "sensor" in found.kernels or rig.position is None or command is None:
            return found
        reading = rig.position, command, rig.position_to_si
        # Gains are known, and the same at each point.
        if not told:
            told.append(controllers_of(found, *reading))
        return found if told[0] is None else with_reading(found, told[0], *reading)

    return kernels_at


def _least_levels(case: Case, problem: Problem, ports: Collection[str]) -> Levels:
    """Levels of noise below which none is looked for."""
    position, is_open = case.rig.position, case.simulations.tracking is not None
    read = problem.positions if not is_open else ()  # that a controller reads
    own = {
        name: _least_own(problem, name, _LEAST_ROUNDING if name in read else 1.0)
        for name in problem.ranges
    }
    sensor = {}
    if "sensor" in ports and position is not None:
        share = 1.0 if is_open else _FAINT
        sensor["sensor"] = share * own[position] / case.rig.position_to_si
    if is_open and position is not None:
        own[position] *= _FOLLOWED  # its noise is at the port: the twin follows it
    return Levels(sensor, own, _LEAST_JITTER_S)


def problem_on(
    case: Case, windows: Sequence[Window], encoder: EncoderCounts | None = None
) -> Problem:
    """State what is compared in some windows of a case.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    windows : sequence of Window
        In order.
    encoder : EncoderCounts, optional
        Without which the twin is simulated.
    """
    records, rig = case.simulations.records, case.rig
    segments = segments_of(records, windows, SETTLING * case.setting.excitation.loop_time)
    recorded = tuple(s.read([q.values for q in records[s.record].signals]) for s in segments)
    ranges: dict[str, float] = {}
    for segment, values in zip(segments, recorded, strict=True):
        for name, row in zip(segment.names, values, strict=True):
            ranges[name] = max(ranges.get(name, 0.0), float(np.ptp(row)))
    resolutions = {
        name: max(s.resolution for r in records for s in r.signals if s.name == name)
        for name in ranges
    }
    logging = logging_of(segments, ranges, resolutions, rig.positions, rig.alignments)
    shortest = STRETCH_LOOP_TIMES * max(case.setting.excitation.loop_time, TORQUE_TIME)
    rows = sum(s.time.size for s in segments)
    stretch = max(64, int(shortest / segments[0].spacing), rows // _MOST_STRETCHES)
    return Problem(case.simulations, segments, recorded, logging, stretch, encoder=encoder)


def _followed(case: Case, problem: Problem, kernels: PortKernels) -> Problem:
    role = case.twin.file.roles.get("inertia")
    held = (role, case.twin.nominal(role)) if role else None
    return replace(problem, followed=kernels, held_inertia=held)


def _first(case: Case, problem: Problem) -> Fitted:
    setting, runs = case.setting, case.base.simulated
    if problem.encoder is not None:
        setting = replace(setting, difference_steps={})  # those that counts had asked for
        point = problem.point(Hypothesis(setting), case.base.x)
        runs = case.simulations.run([point])[0]
    hypothesis = Hypothesis(setting)
    priors = priors_of(hypothesis, ())
    values = problem.values(runs)
    first = Fitted(
        hypothesis,
        (),
        priors,
        coordinates_of(priors, case.base.x),
        np.zeros(len(problem.nuisances)),
        runs,
        values,
        [y - v for y, v in zip(problem.recorded, values, strict=True)],
        [],
        False,
        problem.logging.one_sided,
        np.zeros((len(case.simulations.records), case.base.x.size)),
    )
    if problem.encoder is None:
        return first
    return TrialPoints(problem, hypothesis).with_judged_steps(first, problem.square_by_range)


def _least_own(problem: Problem, name: str, rounded: float) -> float:
    """[SI] Noise of a column below which none is looked for, some of its rounding or all."""
    rounding = problem.logging.resolutions[name]
    share = _LEAST_OWN_POSITION if name in problem.positions else _LEAST_OWN
    least = max(rounded * rounding / np.sqrt(12.0), share * problem.ranges[name])
    return float(max(least, _LEAST_SI))


def _usual_torque(case: Case) -> float:
    excitation = case.setting.excitation
    if excitation.effective_current is None:
        return _COMMAND_SHARE * excitation.torque
    return excitation.torque * excitation.effective_current / excitation.current


def _elements(
    case: Case, effects: Collection[str], passing: Sequence[Candidate], held: Collection[str]
) -> tuple[Element, ...]:
    excitation = case.setting.excitation
    found = [*candidates(effects, excitation), *(c for c in passing if c.effect in effects)]
    added = [Element(candidate=c.with_nuisances(excitation)) for c in found]
    return (*added, *(Element(freed=u) for u in fixed_parameters(case, held)))
