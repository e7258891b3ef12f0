"""State the comparison of an opened case: stretches, elements, least levels, paths of noise."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.case.command_signal import command_of
from gmfbo.diagnosis.comparison.moves import Element
from gmfbo.diagnosis.comparison.noise_places import Levels
from gmfbo.diagnosis.comparison.nuisance_columns import nuisance_names
from gmfbo.diagnosis.comparison.numbers import (
    INADEQUACY_TOLERANCE,
    STRETCH_LOOP_TIMES,
    TOLERANCE,
    TORQUE_TIME,
)
from gmfbo.diagnosis.comparison.port_kernels import PortKernels, port_kernels
from gmfbo.diagnosis.comparison.posterior_mode import Fitted
from gmfbo.diagnosis.comparison.priors import priors_of
from gmfbo.diagnosis.comparison.problem import Problem
from gmfbo.diagnosis.comparison.search import Ledger, Scored, Search
from gmfbo.diagnosis.comparison.segments import segments_of
from gmfbo.diagnosis.fitting.hypothesis import Candidate, Hypothesis
from gmfbo.diagnosis.screening.testable_effects import candidates, untestable
from gmfbo.physics import CATALOGUE
from gmfbo.sources.twin.uncertain import Uncertain

_MOST_STRETCHES = 200
_LINEAR = frozenset({"timing", "gain", "inertia", "sensor"})
"""Families of effects that noise passes as a linear path."""

_FREED_RANGE = 4.0
"""Times the value of a freed parameter, either way: three standard deviations and a half."""

_LEAST_OWN, _LEAST_OWN_POSITION = 5e-5, 2e-6  # of a signal's range
_LEAST_ROUNDING = 0.1  # of a resolution: a reading may be rounded before the controller reads it
_LEAST_JITTER_S = 1e-7
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
        return self.search.searched(self.search.opened(self.first))


def comparison_of(
    case: Case,
    passing: Sequence[Candidate] = (),
    log: Callable[[str], None] = lambda line: None,
) -> Comparison:
    """State the comparison of a case.

    Parameters
    ----------
    case : Case
        Twin and recordings; its setting knows the lines to look for, its simulators stay open.
    passing : sequence of Candidate
        Disturbances that passed once, as a search found them.
    log : callable (str)
        Told what happens.
    """
    problem = _problem(case)
    own = {name: _least_own(case, problem, name) for name in problem.ranges}
    simulations, rig = case.simulations, case.rig
    excitation = case.setting.excitation
    is_open = simulations.tracking is not None
    sizes = {
        "sensor": excitation.stroke,
        "torque": excitation.torque,
        "command": excitation.command,
    }

    def kernels_at(fitted: Fitted) -> PortKernels:
        linear = tuple(
            c
            for c in fitted.hypothesis.effects
            if c.law.family in _LINEAR or c.effect == "torsional_compliance"
        )
        hypothesis = Hypothesis(fitted.hypothesis.setting, linear)
        point = problem.point(hypothesis, hypothesis.start(fitted.parameters))
        command = command_of(case)
        return port_kernels(simulations, point, sizes, rig.position, rig.position_to_si, command)

    first = _first(case, problem)
    ports = set(first.runs[0].response.ports) | ({"sensor"} if is_open else set())
    if is_open and rig.position is not None:
        problem = _followed(case, problem, kernels_at(first))
        first = replace(first, nuisances=np.zeros(len(problem.nuisances)))
        own[rig.position] *= 0.02  # its noise is at the port: the twin follows it
    sensor = {}
    if "sensor" in ports and rig.position is not None:
        share = 1.0 if is_open else 1e-3
        sensor["sensor"] = share * own[rig.position] / rig.position_to_si
    cared = {p: TOLERANCE * size for p, size in sizes.items() if p != "sensor" and p in ports}
    search = Search(
        problem,
        _elements(case, passing),
        Levels(sensor, own, _LEAST_JITTER_S),
        cared,
        INADEQUACY_TOLERANCE * _usual_torque(case),
        kernels_at,
        log,
    )
    return Comparison(search, first)


def _problem(case: Case) -> Problem:
    records, rig = case.simulations.records, case.rig
    segments = segments_of(records, case.budget.windows)
    recorded = tuple(s.read([q.values for q in records[s.record].signals]) for s in segments)
    nuisances = tuple(nuisance_names(segments, rig.positions, rig.alignments))
    shortest = STRETCH_LOOP_TIMES * max(case.setting.excitation.loop_time, TORQUE_TIME)
    rows = sum(s.time.size for s in segments)
    stretch = max(64, int(shortest / segments[0].spacing), rows // _MOST_STRETCHES)
    return Problem(
        case.simulations, segments, recorded, rig.positions, rig.alignments, nuisances, stretch
    )


def _followed(case: Case, problem: Problem, kernels: PortKernels) -> Problem:
    role = case.twin.file.roles.get("inertia")
    held = (role, case.twin.nominal(role)) if role else None
    return replace(problem, followed=kernels.kernels["sensor"], held_inertia=held)


def _first(case: Case, problem: Problem) -> Fitted:
    hypothesis = Hypothesis(case.setting)
    priors = priors_of(hypothesis, ())
    values = problem.values(case.base.simulated)
    return Fitted(
        hypothesis,
        (),
        priors,
        np.array([p.to_u(v) for p, v in zip(priors, case.base.x, strict=True)]),
        np.zeros(len(problem.nuisances)),
        case.base.simulated,
        values,
        [y - v for y, v in zip(problem.recorded, values, strict=True)],
        [],
        False,
    )


def _least_own(case: Case, problem: Problem, name: str) -> float:
    """[SI] Noise of a column below which none is looked for."""
    rounding = max(
        s.resolution for r in case.simulations.records for s in r.signals if s.name == name
    )
    share = _LEAST_OWN_POSITION if name in problem.positions else _LEAST_OWN
    return float(max(_LEAST_ROUNDING * rounding / np.sqrt(12.0), share * problem.ranges[name]))


def _usual_torque(case: Case) -> float:
    excitation = case.setting.excitation
    if excitation.effective_current is None:
        return _COMMAND_SHARE * excitation.torque
    return excitation.torque * excitation.effective_current / excitation.current


def _elements(case: Case, passing: Sequence[Candidate]) -> tuple[Element, ...]:
    excitation = case.setting.excitation
    reasons = untestable(
        case.twin.file,
        excitation,
        has_inertia=case.setting.inertia is not None,
        is_open=case.simulations.tracking is not None,
    )
    testable = [name for name in CATALOGUE if name not in reasons]
    found = [*candidates(testable, excitation), *(c for c in passing if c.effect in testable)]
    effects = [Element(candidate=c) for c in found]
    return (*effects, *(Element(freed=u) for u in _fixed_parameters(case)))


def _fixed_parameters(case: Case) -> list[Uncertain]:
    """Real parameters that the twin file holds fixed, and that a small factor may change."""
    file, binding = case.twin.file, case.twin.binding
    stated = {*file.uncertain, *file.initial, *file.gains}
    found = []
    for name, bound in binding.parameters.items():
        variable, value = bound.variable, binding.nominal(name)
        is_scalar = variable.type == "Real" and value != 0.0
        if name in stated or not is_scalar or variable.variability == "fixed":
            continue
        low, high = sorted((value / _FREED_RANGE, value * _FREED_RANGE))
        low = max(low, variable.minimum if variable.minimum is not None else low)
        high = min(high, variable.maximum if variable.maximum is not None else high)
        if low < value < high:
            found.append(Uncertain(name, value, low, high))
    return found
