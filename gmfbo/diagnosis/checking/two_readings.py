"""What holds whether inputs are held between their rows or go straight to the next one.

A controller that is faster than its logger sees a smooth reference. Held from row to row, the
reference kicks the twin's command at each row, which looks like a wrong scale or clock. Where the
twin file does not say how inputs run, only what both readings show is told.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gmfbo.diagnosis.checking.grouped_findings import grouped, told_together
from gmfbo.diagnosis.checking.result import Finding, RecordingFacts, ResponseSeen, SeenAlignment
from gmfbo.diagnosis.locating.parity import FAILS_ABOVE
from gmfbo.diagnosis.runs.twin_steps import inputs_unstated
from gmfbo.plain_words import listed
from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin.twin import FmuTwin

_NOT_COMPUTED = "controller_parity"
_BY_CONTROLLER = {
    "shifted_column",
    "scaled_column",
    "offset_column",
    "controller_gain",
    "held_before",
    _NOT_COMPUTED,
}


@dataclass(frozen=True)
class Reading:
    """What one reading of the inputs shows.

    Attributes
    ----------
    findings : tuple of Finding
        Faults, worst first.
    facts : mapping of str to RecordingFacts
        By recording.
    logged : mapping of str to str
        By signal: the logger stores the `held` or `new` value.
    why_not : str
        Why the controller could not be checked; empty where it was.
    responses : tuple of ResponseSeen
        From the reference to each signal.
    """

    findings: tuple[Finding, ...]
    facts: Mapping[str, RecordingFacts]
    logged: Mapping[str, str]
    why_not: str
    responses: tuple[ResponseSeen, ...]


def slower_inputs(twin: FmuTwin, recordings: Sequence[Recording]) -> list[str]:
    """Unstated inputs that a recording holds more slowly than the twin steps.

    Parameters
    ----------
    twin : FmuTwin
        The user's twin.
    recordings : sequence of Recording
        Runs of the real axis.
    """
    return [
        name
        for name in sorted(inputs_unstated(twin))
        if any(round(_spacing(recording, name) / twin.step) > 1 for recording in recordings)
    ]


def _spacing(recording: Recording, name: str) -> float:
    if name not in recording.signals:
        return 0.0
    times = recording.time[np.isfinite(recording.signal(name))]
    return float(np.median(np.diff(times))) if times.size > 1 else 0.0


def straight(twin: FmuTwin, names: Sequence[str]) -> FmuTwin:
    """The same twin, of which some inputs go straight from row to row.

    Parameters
    ----------
    twin : FmuTwin
        The user's twin.
    names : sequence of str
        Of `[inputs]`.
    """
    inputs = twin.file.inputs
    drawn = {name: inputs[name].model_copy(update={"interpolation": "linear"}) for name in names}
    return twin.with_file(twin.file.model_copy(update={"inputs": {**inputs, **drawn}}))


def note_on(names: Sequence[str]) -> list[str]:
    """Say what was done, and how the twin file says it; nothing where it leaves nothing open.

    Parameters
    ----------
    names : sequence of str
        Inputs that it leaves open.
    """
    if not names:
        return []
    return [
        f"the twin file leaves open how inputs run between their rows ({listed(names)}): only what "
        'shows both held and straight to the next row is told; write interpolation = "linear" or '
        '"hold" there'
    ]


def agreed(one: Reading, other: Reading) -> Reading:
    """What both readings show, each size as the one nearer to no fault.

    Parameters
    ----------
    one, other : Reading
        Of the same recordings.
    """
    responses = {response.signal: response for response in other.responses}
    return Reading(
        findings=_agreed_findings(one, other),
        facts={name: _agreed_facts(own, other.facts[name]) for name, own in one.facts.items()},
        logged={n: how for n, how in one.logged.items() if other.logged.get(n) == how},
        why_not=one.why_not or other.why_not,
        responses=tuple(
            min(own, responses.get(own.signal, own), key=lambda seen: seen.apart)
            for own in one.responses
        ),
    )


def _agreed_findings(one: Reading, other: Reading) -> tuple[Finding, ...]:
    found = []
    for own in one.findings:
        same = [
            counterpart
            for counterpart in other.findings
            if own.recording == counterpart.recording and len(grouped([own, counterpart])) == 1
        ]
        if same and _is_one_side(one, other, own):
            found.append(replace(own, what=told_together([own.what, same[0].what])))
    explained = {finding.recording for finding in found if finding.kind in _BY_CONTROLLER}
    return (*found, *_not_computed(one, other, explained))


def _not_computed(one: Reading, other: Reading, explained: Collection[str]) -> list[Finding]:
    """What is left where only one reading explains the controller's residual by a column."""
    left = {f.recording: f for f in (*one.findings, *other.findings) if f.kind == _NOT_COMPUTED}
    return [
        replace(
            finding,
            what="is not what the twin's controller computes from the recorded measurement, "
            "whether inputs are held or straight between their rows",
        )
        for name, finding in left.items()
        if name not in explained
        and all(reading.facts[name].parity > FAILS_ABOVE for reading in (one, other))
    ]


def _is_one_side(one: Reading, other: Reading, finding: Finding) -> bool:
    """Whether a scale or an offset is on the same side in both; a shift says so in words."""
    seen = [
        reading.facts[finding.recording].alignment.get(finding.signal)
        for reading in (one, other)
        if finding.recording in reading.facts
    ]
    sizes = {
        "scaled_column": [own.scale - 1.0 for own in seen if own is not None],
        "offset_column": [own.offset for own in seen if own is not None],
    }.get(finding.kind, [])
    return not sizes or min(sizes) * max(sizes) > 0.0


def _agreed_facts(one: RecordingFacts, other: RecordingFacts) -> RecordingFacts:
    alignment = {
        name: _agreed_alignment(own, other.alignment[name])
        for name, own in one.alignment.items()
        if name in other.alignment
    }
    return replace(one, alignment=alignment, parity=float(np.minimum(one.parity, other.parity)))


def _agreed_alignment(one: SeenAlignment, other: SeenAlignment) -> SeenAlignment:
    return SeenAlignment(
        one.basis if one.basis == other.basis else "twin",
        _nearest(0.0, one.shift, other.shift),
        _nearest(1.0, one.scale, other.scale),
        _nearest(0.0, one.offset, other.offset),
        min(one.explained, other.explained),
    )


def _nearest(nothing: float, one: float, other: float) -> float:
    """Value between two that is nearest to no fault; NaN where either is."""
    return float(np.clip(nothing, np.minimum(one, other), np.maximum(one, other)))
