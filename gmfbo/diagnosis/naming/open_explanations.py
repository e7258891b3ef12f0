"""The explanations that a diagnosis leaves open, gathered for predictions."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from gmfbo.diagnosis.case.case import Case, chi2_per_dof
from gmfbo.diagnosis.comparison.numbers import TOLD_APART
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.diagnosis.naming.decision import Decision
from gmfbo.diagnosis.result.predictions import PARAMETERS_ONLY, Explanation, Predictions, Span
from gmfbo.diagnosis.runs.measured_excitation import states_of
from gmfbo.physics import Units


def predictions_of(case: Case, decision: Decision, augmented: Fitted, units: Units) -> Predictions:
    """Gather what it takes to predict recordings under each explanation that remains.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    decision : Decision
        What was accepted, and its rivals.
    augmented : Fitted
        The twin with what was accepted, as it is exported.
    units : Units
        Of the twin.
    """
    plain = case.plain
    certain = {u.name for u in case.setting.uncertain}
    fits = {}
    if augmented.hypothesis.effects or decision.freed:
        fits[name_of(augmented, certain)] = augmented
    for rival in (rival for entry in decision.rounds for rival in entry.rivals):
        fits.setdefault(name_of(rival.fitted, certain), rival.fitted)
    fits.setdefault(PARAMETERS_ONLY, case.base)
    return Predictions(
        explanations=tuple(
            _explanation(name, fitted, chi2_per_dof(fitted.measured_by(plain), plain))
            for name, fitted in fits.items()
        ),
        threshold=TOLD_APART,
        noise={name: level.total for name, level in case.noise.items()},
        spans=_spans(case, units),
        new_rows=tuple(sorted(case.simulations.new_rows)),
        straight=tuple(n for n, e in case.twin.file.inputs.items() if e.interpolation == "linear"),
    )


def name_of(fitted: Fitted, uncertain: Collection[str]) -> str:
    """Effects and freed parameters of a fit, joined by " + ".

    Parameters
    ----------
    fitted : Fitted
        An explanation.
    uncertain : collection of str
        Parameters that every explanation refits.
    """
    hypothesis = fitted.hypothesis
    freed = [f"parameter:{u.name}" for u in hypothesis.setting.uncertain if u.name not in uncertain]
    return " + ".join([*(c.effect for c in hypothesis.effects), *freed]) or PARAMETERS_ONLY


def _explanation(name: str, fitted: Fitted, misfit: float) -> Explanation:
    hypothesis = fitted.hypothesis
    point = hypothesis.point(fitted.x)
    physics = {k: v for k, v in point.physics.items() if k.partition(".")[0] not in point.only}
    effects = tuple(candidate.effect for candidate in hypothesis.effects)
    return Explanation(name, effects, fitted.parameters, physics, misfit)


def as_candidate(effect: str, physics: Mapping[str, float]) -> Candidate:
    """Return an effect at the values of an explanation, fixed ones too."""
    own = {
        name.partition(".")[2]: value
        for name, value in physics.items()
        if name.partition(".")[0] == effect
    }
    empty = Candidate(effect, {})
    fitted = {parameter.name for parameter in empty.law.parameters}
    return Candidate(
        effect,
        {name: value for name, value in own.items() if name in fitted},
        {name: value for name, value in own.items() if name not in fitted},
    )


def _spans(case: Case, units: Units) -> dict[str, Span]:
    states = [
        states_of(run, record)
        for run, record in zip(case.base.simulated, case.simulations.records, strict=True)
    ]
    names = {"position": units.position, "velocity": units.velocity, "command": units.command}
    names |= {"current": units.current, "load": units.load}
    spans = {}
    for name, unit in names.items():
        column = np.concatenate([getattr(s, name) for s in states])
        spans[name] = Span(float(column.min()), float(column.max()), unit)
    torque = case.setting.excitation.torque
    return {**spans, "torque": Span(-torque, torque, units.torque)}
