"""Late, scaled and offset columns and wrong gains in words, each with its cure."""

from __future__ import annotations

import math

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.case.command_signal import command_of
from gmfbo.diagnosis.checking.result import Finding, RecordingFacts, SeenAlignment
from gmfbo.diagnosis.checking.seen_alignment import (
    LEAST_GAIN,
    LEAST_OFFSET,
    LEAST_SCALE,
    ControllerView,
    Culprit,
)
from gmfbo.diagnosis.locating.parity import FAILS_ABOVE
from gmfbo.diagnosis.scoring.nuisances import SHIFT_SHARE, Alignment
from gmfbo.plain_words import duration, number, quantity

_FARTHEST = 1.5  # standard deviations of a nuisance's prior above which an error is reported
_SHIFT = 0.5  # of a sample: a smaller shift is not reported
_BY_CONTROLLER = (0.9, 0.95)  # least share by one error, where the rest is noise, and elsewhere
_BY_TWIN = 0.9  # the same against the twin, where missing physics may look alike


def of_alignment(
    case: Case, name: str, facts: RecordingFacts, view: ControllerView | None
) -> list[Finding]:
    """Findings by the controller's residual; against the twin alone where there is none.

    Parameters
    ----------
    case : Case
        At nominal parameters.
    name : str
        Of the recording.
    facts : RecordingFacts
        Its facts.
    view : ControllerView or None
        The controller's residual in it, where it could be checked.
    """
    if view is not None:
        return _by_controller(case, name, view)
    found = []
    for signal, seen in facts.alignment.items():
        found += _by_twin(case, name, signal, seen)
    return found


def _by_controller(case: Case, name: str, view: ControllerView) -> list[Finding]:
    """Findings by the controller's parity; none where it computes the recorded command."""
    if view.excess <= FAILS_ABOVE:
        return _held_before(case, name, view)
    best = _alone(view)
    if best is not None and best.kind == "gain":
        return [_of_gain(name, best)] if abs(best.size) > LEAST_GAIN else []
    if best is not None:
        prior = case.rig.alignments[best.signal]
        if not _is_far(best, prior, _sample(case, best.signal)):
            return []
        return [_of_culprit(name, best, _unit(case, best.signal), "the controller's command")]
    return [
        Finding(
            "controller_parity",
            name,
            command_of(case) or "",
            "is not what the twin's controller computes from the recorded measurement, "
            + (
                "and no shift, scale or offset of one column explains it"
                if view.culprits
                else "whatever that did between its rows"
            ),
            "check gains, filters and limits of the controller against the drive's",
        )
    ]


def _held_before(case: Case, name: str, view: ControllerView) -> list[Finding]:
    """A constant of the command that an integral and an offset of the column explain alike."""
    command = command_of(case) or ""
    # Ten times the range stands for an offset that the twin file leaves free.
    is_free = bool(command) and case.rig.alignments[command].offset >= 1.0
    if abs(view.held) <= LEAST_OFFSET * _extent(case, name, command) or is_free:
        return []
    return [
        Finding(
            "held_before",
            name,
            command,
            f"differs by {quantity(view.held, _unit(case, command))} throughout from what the "
            "twin's controller computes: its integral held that before the first row, or the "
            "column has an offset",
            "leave the column as it is if the drive was on before; to tell the two apart, begin a "
            "recording before the drive is switched on",
        )
    ]


def _alone(view: ControllerView) -> Culprit | None:
    """Single error that explains the controller's residual; None where none does."""
    if not view.culprits:
        return None
    best = view.culprits[0]
    to_noise = (1.0 - best.explained) * view.excess <= FAILS_ABOVE
    return best if best.explained >= _BY_CONTROLLER[0 if to_noise else 1] else None


def _of_gain(name: str, culprit: Culprit) -> Finding:
    return Finding(
        "controller_gain",
        name,
        culprit.signal,
        f"was {number(1.0 + culprit.size)} times the value in force, as the controller's command "
        "shows",
        f"state the gain that the drive had: a line # {culprit.signal} = VALUE in the recording",
    )


def _by_twin(case: Case, name: str, signal: str, seen: SeenAlignment) -> list[Finding]:
    """Findings against the twin alone, where shift, scale and offset explain nearly all.

    A shift is not told: friction, or a twin that is too light, makes a column late as well.
    """
    if seen.explained < _BY_TWIN:
        return []
    sample, prior = _sample(case, signal), case.rig.alignments[signal]
    parts = [
        Culprit(signal, "scale", seen.scale - 1.0, seen.explained),
        Culprit(signal, "offset", seen.offset, seen.explained),
    ]
    least = {
        "scale": LEAST_SCALE,
        "offset": LEAST_OFFSET * _extent(case, name, signal),
    }
    return [
        _of_culprit(name, part, _unit(case, signal), "the twin (or physics is missing)")
        for part in parts
        if abs(part.size) > least[part.kind] and _is_far(part, prior, sample)
    ]


def _extent(case: Case, name: str, signal: str) -> float:
    for record in case.simulations.records:
        for own in record.signals:
            if record.name == name and own.name == signal:
                return float(own.values.max() - own.values.min())
    return math.inf


def _is_far(culprit: Culprit, prior: Alignment, sample: float) -> bool:
    """Whether an error exceeds the nuisances that a diagnosis removes anyway."""
    if culprit.kind == "shift":
        allowed = prior.shift or SHIFT_SHARE * sample
        return abs(culprit.size) > max(_FARTHEST * allowed, _SHIFT * sample)
    if culprit.kind == "scale":
        return abs(culprit.size) > _FARTHEST * prior.scale
    # Ten times the range stands for an offset that the twin file leaves free.
    return prior.offset < 1.0


def _of_culprit(name: str, culprit: Culprit, unit: str, against: str) -> Finding:
    signal, size = culprit.signal, culprit.size
    if culprit.kind == "shift":
        side = "late" if size > 0.0 else "early"
        return Finding(
            "shifted_column",
            name,
            signal,
            f"is {duration(abs(size))} {side} against {against}",
            f"correct its time, or give {signal} a shift_range in the twin file",
        )
    if culprit.kind == "scale":
        return Finding(
            "scaled_column",
            name,
            signal,
            f"is {number(1.0 + size, 4)} times what it should be against {against}",
            f"correct its scale or unit, or give {signal} an uncertain_scale in the twin file",
        )
    return Finding(
        "offset_column",
        name,
        signal,
        f"is off by {quantity(size, unit)} against {against}",
        f'correct its zero, or write offset = "fit" for {signal} in the twin file',
    )


def _sample(case: Case, signal: str) -> float:
    spacings = [s.spacing for r in case.simulations.records for s in r.signals if s.name == signal]
    return spacings[0] if spacings else case.twin.step


def _unit(case: Case, signal: str) -> str:
    variable = case.twin.file.outputs[signal].variable
    return case.twin.binding.variables[variable].variable.si_unit
