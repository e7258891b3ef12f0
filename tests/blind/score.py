"""Holds what a diagnosis said of each case against what was hidden.

A name is right where it is that of a hidden effect; friction laws count as one family. Where the
name is another one but the hidden effect is in its `indistinguishable_from`, the outcome is `set`:
neither right nor wrong. Whatever is named in a null, in a decoy, or where the twin lacks the port
is wrong; but the name of what a motion in one direction hides is none. Outside the catalogue the
right answer is the verdict `outside_library`; a name that is not part of the mismatch is wrong, and
any name without the verdict is a false one.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from tests.blind.generate import check_hashes
from tests.blind.hidden import FRICTION
from tests.blind.numbers_said import Numbers, judge_numbers
from tests.blind.run import outcome_path

Outcome = Literal["right", "partial", "set", "wrong", "missed", "nearest", "failed"]

STATE_WORDS = {
    "velocity": ("velocity", "speed", "reversal"),
    "position": ("position", "angle"),
    "command": ("command", "current", "torque", "voltage"),
    "time": ("time",),
}
"""Words by which a region names the state that it is told in."""

NOTHING_TO_NAME = ("null", "stressed_null", "decoy")

OWED = 60.0
"""Oracle gain above which the name is owed."""

ABSTAIN = 15.0
"""Oracle gain below which only abstention is right."""


@dataclass(frozen=True)
class Scored:
    """One case, judged.

    Attributes
    ----------
    case, kind, machine : str
        As in the answer.
    hidden, named : tuple of str
        Names, hidden and given.
    gain : float
        The oracle's, over parameters alone; of a pair, what the smaller one adds to the other.
    within_reach : bool
        Whether the twin has the ports.
    outcome : str
        See the module.
    path_right, place_right : bool or None
        Signal path, and state with times; None where they are not judged.
    true_path, said_path : str
        For the table of places.
    claims : tuple of (float, bool)
        Probability of each name given, and whether it is right.
    verdict : str
        As given; empty where there is none.
    removed : float or None
        Explainable error removed.
    is_exact : bool
        The very law was named, not only its family.
    numbers : Numbers
        Parameters and held-out errors against the truth.
    details : tuple of str
        Stresses or decoy.
    simulations, seconds : float
        Cost as told, and wall clock of the command.
    note : str
        Why a case failed.
    """

    case: str
    kind: str
    machine: str
    hidden: tuple[str, ...]
    named: tuple[str, ...]
    gain: float
    within_reach: bool
    outcome: Outcome
    path_right: bool | None = None
    place_right: bool | None = None
    true_path: str = ""
    said_path: str = ""
    claims: tuple[tuple[float, bool], ...] = ()
    verdict: str = ""
    removed: float | None = None
    is_exact: bool = False
    numbers: Numbers = field(default_factory=Numbers)
    details: tuple[str, ...] = ()
    simulations: float = 0.0
    seconds: float = 0.0
    note: str = ""

    @property
    def can_be_named(self) -> bool:
        """An effect of the catalogue is hidden, and the twin has its port."""
        return self.kind in ("single", "pair") and self.within_reach

    @property
    def is_owed(self) -> bool:
        """A right diagnosis names it."""
        return self.can_be_named and self.gain > OWED

    @property
    def has_false_name(self) -> bool:
        """A name that nothing bears out, at any probability."""
        if self.kind == "outside":
            return bool(self.named) and self.outcome != "right"
        return self.outcome == "wrong"


def family(name: str) -> str:
    """Name under which an effect is compared."""
    return "friction" if name in FRICTION else name


def score_case(
    answer: Mapping[str, Any], diagnosis: Mapping[str, Any] | None, seconds: float, note: str = ""
) -> Scored:
    """Judge one case.

    Parameters
    ----------
    answer : mapping
        Of `cases.Answer`.
    diagnosis : mapping or None
        Content of diagnosis.json; None where the command left none.
    seconds : float
        [s] Wall clock of the command.
    note : str
        Why there is no diagnosis.
    """
    hidden = tuple(effect["name"] for effect in answer["effects"])
    common: dict[str, Any] = {
        "case": answer["case"],
        "kind": answer["kind"],
        "machine": answer["machine"],
        "hidden": hidden,
        "gain": case_gain(answer),
        "details": tuple(answer.get("details", {}).get("stress", ())),
        "within_reach": bool(answer["within_reach"]),
        "seconds": seconds,
    }
    if diagnosis is None:
        return Scored(**common, named=(), outcome="failed", note=note)
    effects = diagnosis.get("effects", [])
    judged = [_judge_claim(effect, answer) for effect in effects]
    outcome = _outcome(answer, effects, judged, str(diagnosis.get("verdict", "")))
    path, place = _location(answer, diagnosis, outcome)
    said = (diagnosis.get("location") or {}).get("signal_path") or "none"
    return Scored(
        **common,
        named=tuple(effect["name"] for effect in effects),
        outcome=outcome,
        path_right=path,
        place_right=place,
        true_path=answer["effects"][0]["signal_path"][0] if hidden else "none",
        said_path=said,
        claims=tuple(
            (float(effect.get("probability") or 0.0), verdict == "right")
            for effect, verdict in zip(effects, judged, strict=True)
        ),
        verdict=str(diagnosis.get("verdict", "")),
        removed=(diagnosis.get("fit") or {}).get("explainable_error_removed"),
        is_exact=bool(hidden) and {effect["name"] for effect in effects} == set(hidden),
        numbers=judge_numbers(answer, diagnosis),
        simulations=float((diagnosis.get("cost") or {}).get("simulations") or 0.0),
    )


def _judge_claim(
    effect: Mapping[str, Any], answer: Mapping[str, Any]
) -> Literal["right", "set", "wrong"]:
    if not answer["within_reach"] or answer["kind"] == "outside":
        return "wrong"
    true = {family(hidden["name"]) for hidden in answer["effects"]}
    if family(effect["name"]) in true:
        return "right"
    rivals = {family(name) for name in effect.get("indistinguishable_from") or ()}
    return "set" if rivals & true else "wrong"


def _outcome(
    answer: Mapping[str, Any], effects: Sequence[Any], judged: Sequence[str], verdict: str
) -> Outcome:
    if answer["kind"] == "outside":
        nearest = set(answer["nearest"])
        if not all(effect["name"] in nearest for effect in effects):
            return "wrong"
        if verdict == "outside_library":
            return "right"
        return "nearest" if effects else "missed"
    if "wrong" in judged:
        return "wrong"
    if answer["kind"] in NOTHING_TO_NAME or not answer["within_reach"]:
        return "right"
    if not effects:
        return "missed"
    true = {family(hidden["name"]) for hidden in answer["effects"]}
    named = {family(effect["name"]) for effect in effects}
    if "set" in judged:
        return "set"
    return "right" if named == true and len(effects) == len(answer["effects"]) else "partial"


def _location(
    answer: Mapping[str, Any], diagnosis: Mapping[str, Any], outcome: str
) -> tuple[bool | None, bool | None]:
    """Whether the signal path, and state with times, are right; None where not judged."""
    if outcome not in ("right", "partial") or not answer["effects"] or not diagnosis["effects"]:
        return None, None
    location = diagnosis.get("location") or {}
    named = {family(effect["name"]) for effect in diagnosis["effects"]}
    true = [effect for effect in answer["effects"] if family(effect["name"]) in named]
    path = any(location.get("signal_path") in effect["signal_path"] for effect in true)
    local = [effect for effect in true if effect["windows"] or "position" in effect["states"]]
    if not local:
        return path, None
    region = str(location.get("region") or "").lower()
    times = location.get("times") or []
    return path, any(
        any(word in region for state in effect["states"] for word in STATE_WORDS[state])
        and (not effect["windows"] or overlaps(times, effect["windows"]))
        for effect in local
    )


def overlaps(said: Sequence[Sequence[Any]], true: Sequence[Sequence[Any]]) -> bool:
    """Whether at least half of the windows that were said meet a true one."""
    met = sum(
        any(
            Path(str(name)).name == Path(str(other)).name and start <= late and end >= early
            for other, early, late in true
        )
        for name, start, end in said
    )
    return len(said) > 0 and 2 * met >= len(said)


def case_gain(answer: Mapping[str, Any]) -> float:
    """Oracle gain of a case; of a pair, what the smaller effect adds to the other."""
    if answer["kind"] == "pair":
        return min(float(e.get("added_gain", answer["oracle_gain"])) for e in answer["effects"])
    return float(answer["oracle_gain"])


def read_scores(out: Path) -> list[Scored]:
    """Judge all cases of a benchmark that have been run.

    Raises
    ------
    ValueError
        An answer is not the one that was hashed.
    """
    check_hashes(out)
    scores = []
    for path in sorted((out / "answers").glob("*.json")):
        ended = outcome_path(out, path.stem)
        if not ended.exists():
            continue
        outcome = json.loads(ended.read_text(encoding="utf-8"))
        answer = json.loads(path.read_text(encoding="utf-8"))
        written = ended.with_name("diagnosis.json")
        diagnosis = None
        if outcome["status"] == 0 and written.exists():
            diagnosis = json.loads(written.read_text(encoding="utf-8"))
        scores.append(score_case(answer, diagnosis, outcome["seconds"], outcome["note"]))
    return scores


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line: python -m tests.blind.score."""
    from tests.blind.baseline_table import baseline_table
    from tests.blind.draw.outcomes import tell
    from tests.blind.placebo import placebo_table
    from tests.blind.tables import report

    parser = argparse.ArgumentParser(description=(__doc__ or "").strip())
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--text", type=Path, help="file for the report")
    parser.add_argument("--placebos", type=Path, nargs="+", default=[], help="their folders")
    given = parser.parse_args(arguments)
    scores = read_scores(given.out)
    more = [baseline_table(given.out, scores)]
    more += [placebo_table(given.placebos)] if given.placebos else []
    benchmark = json.loads((given.out / "benchmark.json").read_text(encoding="utf-8"))
    text = report(scores, benchmark, more)
    tell(text, given.text)


if __name__ == "__main__":
    main()
