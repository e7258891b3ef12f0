"""From a decision to the values of a diagnosis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.diagnosis.fitting.intervals import Spread
from gmfbo.diagnosis.naming.decision import Decision, Round
from gmfbo.diagnosis.result.augmentation import Augmentation
from gmfbo.diagnosis.result.certainty import statement_of
from gmfbo.diagnosis.result.named_effect import (
    DetectableSize,
    IdentifiedValue,
    NamedEffect,
    NotTestable,
    RivalShare,
)
from gmfbo.physics import CATALOGUE, Units
from gmfbo.sources.binding.augmented_binding import PORT_OUTPUTS

if TYPE_CHECKING:
    from gmfbo.sources.export.export import PhysicsParameter


def units_of(case: Case) -> Units:
    """Units of the twin's ports and states, as its FMU spells them."""
    file, variables = case.twin.file, case.twin.binding.variables

    def unit(name: str | None, otherwise: str) -> str:
        return (variables[name].variable.unit or otherwise) if name else otherwise

    states = file.states
    position = unit(states.get("position"), "rad")
    torque = unit(file.ports.get("torque"), "N.m" if position == "rad" else "N")
    command = unit(states.get("command"), unit(file.ports.get("command"), torque))
    current = unit(states.get("current"), command)
    return Units(
        torque=torque,
        position=position,
        velocity=unit(states.get("velocity"), f"{position}/s"),
        command=command,
        current=current,
        load=torque if "load_torque" in states else current,
    )


def named_effects(
    case: Case,
    decision: Decision,
    augmented: Fitted,
    spread: Spread,
    probabilities: Mapping[str, float],
    units: Units,
) -> tuple[NamedEffect, ...]:
    """Accepted effects at the values that the held-out recordings were scored with.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    decision : Decision
        What was accepted.
    augmented : Fitted
        Fit to the recordings that were not held out.
    spread : Spread
        Of that fit.
    probabilities : mapping of str to float
        By effect.
    units : Units
        Of the twin.
    """
    rounds = {r.winner.name: r for r in decision.rounds}
    named = []
    place = len(case.setting.uncertain)
    for candidate in augmented.hypothesis.effects:
        law, found = candidate.law, rounds[candidate.effect]
        values = {**candidate.more, **candidate.values}
        identified = {}
        for i, parameter in enumerate(candidate.parameters, start=place):
            identified[parameter.name] = IdentifiedValue(
                float(augmented.x[i]),
                units.resolve(parameter.unit),
                float(spread.low[i]),
                float(spread.high[i]),
            )
        place += len(candidate.parameters)
        rivals, probability = tuple(r.name for r in found.rivals), probabilities[law.name]
        named.append(
            NamedEffect(
                name=law.name,
                port=law.port,
                probability=probability,
                statement=statement_of(
                    law.statement(values, units, units.place), (law.name, *rivals), probability
                ),
                equation=law.equation,
                parameters=identified,
                evidence=found.winner.gain,
                threshold=found.needed,
                evidence_per_recording=_per_recording(case, found),
                indistinguishable_from=rivals,
                rivals=_rival_shares(found, probability),
            )
        )
    return tuple(sorted(named, key=lambda effect: -effect.evidence))


def _rival_shares(found: Round, probability: float) -> tuple[RivalShare, ...]:
    """Divide a probability among its sharers, by Akaike weights (Burnham, Anderson 2002)."""
    if not found.rivals:
        return ()
    alike = (found.winner, *found.rivals)
    criterion = np.array([e.chi2 + 2.0 * e.fitted.x.size for e in alike])
    weights = np.exp(-0.5 * (criterion - criterion.min()))
    shares = probability * weights / weights.sum()
    return tuple(RivalShare(e.name, float(p)) for e, p in zip(alike, shares, strict=True))


def _per_recording(case: Case, found: Round) -> dict[str, float]:
    total: dict[str, float] = {}
    for window, gain in zip(case.budget.windows, found.winner.gains, strict=True):
        name = case.simulations.records[window.record].name
        total[name] = total.get(name, 0.0) + float(gain)
    return total


def detectable_sizes(
    case: Case, decision: Decision, named: Sequence[str], units: Units
) -> dict[str, DetectableSize]:
    """Smallest size of each effect not named that would have gained the threshold."""
    sizes: dict[str, DetectableSize] = {}
    excitation = case.setting.excitation
    for entry in decision.screened:
        candidate = entry.probe.candidate
        law = candidate.law
        if law.name in named or entry.information <= 0.0 or candidate.searched > 1:
            continue  # several lines together show at a smaller size than any of them
        at_probe = entry.probe.scaled(np.ones(len(entry.probe.columns)))
        size = law.size({**at_probe.more, **at_probe.values}, excitation)
        smallest = size * float(np.sqrt(decision.threshold / entry.information))
        if not all(entry.probe.amplitudes):
            smallest = size  # a limit shows whole or not at all
        smallest = max(smallest, law.floor(excitation))
        if law.name not in sizes or smallest < sizes[law.name].size:
            sizes[law.name] = DetectableSize(law.size_name, smallest, units.resolve(law.size_unit))
    return {name: sizes[name] for name in CATALOGUE if name in sizes}


def not_testable(
    case: Case, reasons: Mapping[str, str], decision: Decision
) -> tuple[NotTestable, ...]:
    """Effects on which nothing can be said, in the catalogue's order."""
    entries = []
    named = {entry.winner.name for entry in decision.rounds}
    for name in CATALOGUE:
        if name in named:
            continue
        if name in reasons:
            entries.append(NotTestable(name, reasons[name]))
        elif name in decision.like_parameters:
            entries.append(NotTestable(name, decision.like_parameters[name]))
    return tuple(entries)


def augmentation_of(case: Case, augmented: Fitted, units: Units) -> Augmentation:
    """Everything that the exported twin is made of.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    augmented : Fitted
        Whose values become the defaults.
    units : Units
        Of the twin.
    """

    point = augmented.hypothesis.point(augmented.x)
    fixed = case.simulations.settings
    exposed: list[PhysicsParameter] = []
    for candidate in augmented.hypothesis.effects:
        exposed += _exposed(candidate, point.physics, units)
    shown = {parameter.name for parameter in exposed}
    settings = {
        **{k: v for k, v in fixed.items() if case.twin.file.ports},
        **{name: value for name, value in point.physics.items() if name not in shown},
    }
    simulations = case.simulations
    return Augmentation(
        case.twin,
        point.parameters,
        tuple(exposed),
        settings,
        case.substeps,
        from_rest=augmented.hypothesis.acts_at_rest
        and simulations.begins_at_rest
        and simulations.rest > 0,
    )


def _exposed(
    candidate: Candidate, physics: Mapping[str, float], units: Units
) -> list[PhysicsParameter]:
    from gmfbo.sources.export.export import PhysicsParameter

    law = candidate.law
    return [
        PhysicsParameter(
            f"{law.name}.{parameter.name}",
            physics[f"{law.name}.{parameter.name}"],
            units.resolve(parameter.unit),
            f"{parameter.words}: {law.equation}",
        )
        for parameter in candidate.parameters
        if law.port in PORT_OUTPUTS
    ]
