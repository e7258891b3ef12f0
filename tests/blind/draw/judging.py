"""Holds what was said of a drawn case against what it hides.

Names count after `equivalents`: a parameter that the twin has, and the law that changes the same,
are one statement; friction laws are one family, as in the blind benchmark. In a null any name is
false, and so is the verdict `outside_library`; a fixed parameter that is wrong may be told, alone
or in a set. An owed case is right if all that is hidden is named and nothing else; it is an honest
set if each statement is right or its set holds what is hidden. Outside the library the verdict is
asked for, and a part of the law may be named beside it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from tests.blind.draw.equivalents import PARAMETER, same_statement
from tests.blind.draw.measures import error_left
from tests.blind.gains import OWED, case_gain, family

PHYSICS_CLAIMED = ("named", "outside")
"""Outcomes of a null that are false alarms."""


@dataclass(frozen=True)
class Claim:
    """One statement of a diagnosis.

    Attributes
    ----------
    name : str
        As printed: an effect, or `parameter:NAME`.
    members : frozenset of str
        The set that it was told from, itself included.
    probability : float
        As printed; NaN where none was.
    judged : str
        `right`, `set` (the truth is in its set) or `false`.
    """

    name: str
    members: frozenset[str]
    probability: float
    judged: str = ""


@dataclass(frozen=True)
class Interval:
    """A value that was told, and the true one."""

    name: str
    low: float
    high: float
    true: float

    @property
    def holds(self) -> bool:
        """The truth is inside."""
        return self.low <= self.true <= self.high

    @property
    def width(self) -> float:
        """Half of it, as a share of the true value."""
        return 0.5 * (self.high - self.low) / abs(self.true)


@dataclass(frozen=True)
class Judged:
    """One case, judged.

    Attributes
    ----------
    case, stratum, family, variant, machine : str
        As drawn.
    outcome : str
        Nulls and decoys: `right`, `told` (the fixed parameter), `named`, `outside`. Owed, pairs:
        `right`, `set`, `partial`, `missed`, `wrong`. Outside: `right`, `nearest`, `missed`,
        `wrong`. All: `failed`.
    claims : tuple of Claim
        All statements.
    verdict : str
        As given; empty where there is none.
    size : str
        Class of the oracle's gain.
    is_owed : bool
        The oracle gains enough to ask for the name, or for the verdict outside.
    hidden : tuple of str
        Names.
    intervals : tuple of Interval
        Of values whose truth is known, where the physics is right.
    error_left : float or None
        Share of the explainable error that is left on recordings never fitted; None where there
        is hardly any (`measures.error_left`).
    simulations, seconds, cpu_seconds : float
        Cost as told, wall clock, and time of all processes; NaN where that was not counted.
    note : str
        Why there is no diagnosis.
    """

    case: str
    stratum: str
    family: str
    variant: str
    machine: str
    outcome: str
    claims: tuple[Claim, ...] = ()
    verdict: str = ""
    size: str = ""
    is_owed: bool = False
    hidden: tuple[str, ...] = ()
    intervals: tuple[Interval, ...] = ()
    error_left: float | None = None
    simulations: float = 0.0
    seconds: float = 0.0
    cpu_seconds: float = float("nan")
    note: str = ""

    @property
    def false_names(self) -> tuple[Claim, ...]:
        """Statements that nothing bears out."""
        return tuple(claim for claim in self.claims if claim.judged == "false")

    def told(self) -> str:
        """One line for a log."""
        said = ", ".join(f"{c.name} {c.probability:.2f}" for c in self.claims)
        what = " ".join(part for part in (self.stratum, self.family, self.variant) if part)
        hidden = f" hides {' + '.join(self.hidden)}" if self.hidden else ""
        return f"{what}{hidden}: {self.outcome} ({self.verdict or self.note}) {said}".rstrip()


def judge(line: Mapping[str, Any]) -> Judged:
    """Judge one line of outcomes.

    Parameters
    ----------
    line : mapping
        As `run.run_one` wrote it: answer, diagnosis or None, seconds, note.
    """
    answer, diagnosis = line["answer"], line["diagnosis"]
    details = answer["details"]
    common: dict[str, Any] = {
        "case": line["case"],
        "stratum": details["stratum"],
        "family": details["family"],
        "variant": details["variant"],
        "machine": answer["machine"],
        "size": details["size"],
        "hidden": _hidden(answer),
        "seconds": float(line["seconds"]),
        "note": line["note"],
    }
    if line.get("cpu_seconds") is not None:
        common["cpu_seconds"] = float(line["cpu_seconds"])
    common["is_owed"] = details["stratum"] != "null" and case_gain(answer) > OWED
    if diagnosis is None:
        return Judged(**common, outcome="failed")
    truth = true_statements(answer)
    claims = tuple(_judged(claim, truth) for claim in claims_of(diagnosis))
    verdict = str(diagnosis.get("verdict", ""))
    outcome = _outcome(details["stratum"], truth, claims, verdict)
    return Judged(
        **common,
        outcome=outcome,
        claims=claims,
        verdict=verdict,
        intervals=_intervals(answer, diagnosis, outcome),
        error_left=error_left(diagnosis),
        simulations=float((diagnosis.get("cost") or {}).get("simulations") or 0.0),
    )


def _hidden(answer: Mapping[str, Any]) -> tuple[str, ...]:
    fixed = answer["details"].get("fixed")
    names = [effect["name"] for effect in answer["effects"]]
    return tuple(names + ([PARAMETER + fixed["name"]] if fixed else []))


def true_statements(answer: Mapping[str, Any]) -> frozenset[str]:
    """What a right statement may be, one word for all that is the same.

    Parameters
    ----------
    answer : mapping
        Of the case. Outside the library these are the names that are part of the mismatch.
    """
    if answer["kind"] == "outside":
        return frozenset(_word(name) for name in answer["nearest"])
    return frozenset(_word(name) for name in _hidden(answer))


def claims_of(diagnosis: Mapping[str, Any]) -> list[Claim]:
    """Statements of a diagnosis of schema 1 or 2: effects, then fixed parameters that were freed.

    Parameters
    ----------
    diagnosis : mapping
        Content of diagnosis.json.
    """
    claims: list[Claim] = []
    told: set[str] = set()
    for effect in diagnosis.get("effects") or []:
        rivals = {*(effect.get("set") or ()), *(effect.get("indistinguishable_from") or ())}
        members = frozenset({effect["name"], *rivals})
        probability = effect.get("probability")
        claims.append(
            Claim(effect["name"], members, float("nan" if probability is None else probability))
        )
        told |= members
    for name, entry in (diagnosis.get("parameters") or {}).items():
        own = PARAMETER + name
        if entry.get("fixed") and own not in told and entry.get("value") != entry.get("nominal"):
            stated = entry.get("probability", diagnosis.get("statement_probability"))
            members = frozenset({own, *(entry.get("set") or ())})
            claims.append(Claim(own, members, float("nan" if stated is None else stated)))
    return claims


def _word(name: str) -> str:
    return family(same_statement(name))


def _judged(claim: Claim, truth: frozenset[str]) -> Claim:
    if _word(claim.name) in truth:
        judged = "right"
    else:
        judged = "set" if truth & {_word(name) for name in claim.members} else "false"
    return Claim(claim.name, claim.members, claim.probability, judged)


def _outcome(stratum: str, truth: frozenset[str], claims: tuple[Claim, ...], verdict: str) -> str:
    has_false = any(claim.judged == "false" for claim in claims)
    is_outside = verdict == "outside_library"
    if stratum in ("null", "decoy"):
        if has_false:
            return "named"
        return "outside" if is_outside else "told" if claims else "right"
    if has_false:
        return "wrong"
    if stratum == "outside":
        return "right" if is_outside else "nearest" if claims else "missed"
    if not claims:
        return "missed"
    met = frozenset().union(*({_word(n) for n in claim.members} & truth for claim in claims))
    if met != truth or len(claims) < len(truth):
        return "partial"
    if is_outside or len(claims) > len(truth):  # "something more is missing" is no right answer
        return "partial"
    return "set" if any(claim.judged == "set" for claim in claims) else "right"


def _of_the_twin(answer: Mapping[str, Any]) -> dict[str, float]:
    """True values of the twin's parameters, as its augmented twin holds them.

    The plant tells a motor from its load; the twin's inertia is of both, and the law says how much
    of it is the load's.
    """
    loads = sum(effect.get("values", {}).get("load_inertia", 0.0) for effect in answer["effects"])
    return {
        name: entry["true"] + (loads if same_statement(PARAMETER + name) == "load_inertia" else 0.0)
        for name, entry in answer["parameters"].items()
    }


def _intervals(
    answer: Mapping[str, Any], diagnosis: Mapping[str, Any], outcome: str
) -> tuple[Interval, ...]:
    """Values of the very laws that are hidden, and of the twin where all its physics is right."""
    hidden = {effect["name"]: effect.get("values", {}) for effect in answer["effects"]}
    pairs = []
    for effect in diagnosis.get("effects") or []:
        told, true = effect.get("parameters") or {}, hidden.get(effect["name"], {})
        pairs += [(f"{effect['name']}.{k}", told[k], true[k]) for k in true if k in told]
    is_silent_of_fixed = bool(answer["details"].get("fixed")) and outcome != "told"
    if outcome in ("right", "told") and answer["kind"] != "outside" and not is_silent_of_fixed:
        told = diagnosis.get("parameters") or {}
        fixed = answer["details"].get("fixed")
        true = _of_the_twin(answer)
        true |= {fixed["name"]: fixed["true"]} if fixed else {}
        pairs += [
            (name, told[name], value)
            for name, value in true.items()
            if name in told and told[name].get("identifiable", True)
        ]
    return tuple(
        Interval(name, float(entry["low"]), float(entry["high"]), float(value))
        for name, entry, value in pairs
        if entry.get("low") is not None and entry.get("high") is not None and value
    )
