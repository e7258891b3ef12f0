"""What beliefs have been worth: the line by which the diagnosis tells probabilities.

python -m tests.blind.draw.worth OUTCOMES.jsonl [MORE.jsonl ...] [--text FILE]

Each claim of an effect counts as right where the truth is in its set. Fitted are the three numbers
of `gmfbo.diagnosis.comparison.numbers.WORTH`; printed is how honest the odds were as believed, how
honest by the line that the other machines tell, by that of the first half of the cases on the
second, and by the line in force.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import expit

from gmfbo.diagnosis.comparison.numbers import MOST, WORTH
from gmfbo.diagnosis.naming.worth import most_told, terms, worth
from tests.blind.draw.judging import judge
from tests.blind.draw.measures import NORMAL, recalibration
from tests.blind.draw.outcomes import tell_of

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Stated:
    """One claim of an effect.

    Attributes
    ----------
    belief : float
        In its set.
    gain : float
        [nats] Its log odds.
    right : bool
        Whether the truth is in the set.
    left : float
        Share of what is more than noise on held-out recordings that no name explains.
    machine : str
        Of the case.
    case : int
        Its number.
    is_borne_out : bool
        The 95 % interval of its share of what is held out lies above zero.
    is_physics : bool
        The verdict is `missing_physics`.
    """

    belief: float
    gain: float
    right: bool
    left: float
    machine: str
    case: int
    is_borne_out: bool = True
    is_physics: bool = True


def stated_in(lines: Sequence[Mapping[str, Any]]) -> list[Stated]:
    """All claims of effects of cases that ended.

    Parameters
    ----------
    lines : sequence of mapping
        Of the runner. Diagnoses made before beliefs were told hold them as the set's probability.
    """
    found = []
    for line in lines:
        judged = judge(line)
        if judged.outcome == "failed":
            continue
        claims = {claim.name: claim for claim in judged.claims}
        for effect in line["diagnosis"]["effects"]:
            belief = effect.get("belief")
            found.append(
                Stated(
                    effect["set_probability"] if belief is None else belief,
                    effect["evidence"],
                    claims[effect["name"]].judged != "false",
                    (line["diagnosis"]["remainder"] or {"share": 0.0})["share"],
                    judged.machine,
                    int(judged.case),
                    ((effect["share"] or {"low": 0.0})["low"] or 0.0) > 0.0,
                    judged.verdict == "missing_physics",
                )
            )
    return found


def line_of(stated: Sequence[Stated]) -> Array:
    """The three numbers of `WORTH`, by maximum likelihood."""
    columns, right = _columns(stated), np.array([one.right for one in stated], dtype=float)

    def loss(line: Array) -> float:
        odds = columns @ line
        return float(np.sum(np.logaddexp(0.0, odds) - right * odds))

    return np.asarray(minimize(loss, np.zeros(len(WORTH)), tol=1e-10).x)


def _columns(stated: Sequence[Stated]) -> Array:
    return np.array([terms(one.belief, one.gain) for one in stated])


def of_other_machines(stated: Sequence[Stated]) -> list[float]:
    """Probability of each claim by the line that all other machines tell."""
    lines = {
        machine: line_of([one for one in stated if one.machine != machine])
        for machine in {one.machine for one in stated}
    }
    return [float(expit(_columns([one]) @ lines[one.machine])[0]) for one in stated]


def as_told(probabilities: Sequence[float], stated: Sequence[Stated]) -> list[float]:
    """Probabilities with the limits under which they are told."""
    return [min(p, most_told(one.left)) for p, one in zip(probabilities, stated, strict=True)]


def table(lines: Sequence[Mapping[str, Any]]) -> str:
    """Text of all that is printed of a whole draw; the order of its cases is random."""
    stated, half = stated_in(lines), len(lines) // 2
    line, force = line_of(stated), ", ".join(f"{value:g}" for value in WORTH)
    rows = [
        f"{len(stated)} claims of effects, {np.mean([s.right for s in stated]):.3f} right",
        "fitted line: " + ", ".join(f"{value:.2f}" for value in line) + f"; in force: {force}",
        f"{'probabilities':<34}{'claims':>7}{'Brier':>7}  intercept; slope",
    ]
    for title, cells in recalibrated(stated, half).items():
        rows.append(f"{title:<34}{cells[0]:>7}{cells[1]:>7}  {'; '.join(cells[2:])}")
    return "\n".join([*rows, "", *_by_worth(stated)]) + "\n"


def recalibrated(stated: Sequence[Stated], half: int) -> dict[str, tuple[str, ...]]:
    """Claims, Brier score, intercept and slope of their recalibration, by where odds are from."""
    first = [one for one in stated if one.case < half]
    second = [one for one in stated if one.case >= half]
    others = of_other_machines(stated)
    told = {
        "as believed": _told([one.belief for one in stated], stated),
        "by the line of all other machines": _told(others, stated),
        "the same, as it is told": _told(as_told(others, stated), stated),
        "by the line in force": _told(_in_force(stated), stated),
    }
    if first and second:
        told[f"from case {half} on, by those before"] = by_line_of(first, second)
    return told


def by_line_of(fitted_to: Sequence[Stated], stated: Sequence[Stated]) -> tuple[str, ...]:
    """The same cells, of claims by the line that others tell."""
    return _told(list(expit(_columns(stated) @ line_of(fitted_to))), stated)


def _in_force(stated: Sequence[Stated]) -> list[float]:
    return [worth(one.belief, one.gain) for one in stated]


def _told(probabilities: Sequence[float], stated: Sequence[Stated]) -> tuple[str, ...]:
    right = [one.right for one in stated]
    brier = float(np.mean((np.array(probabilities) - np.array(right)) ** 2))
    fitted = recalibration(probabilities, right)
    cells = ["-", "-"]
    if fitted is not None:
        cells = [
            f"{value:.2f} [{value - NORMAL * error:.2f}, {value + NORMAL * error:.2f}]"
            for value, error in zip(*fitted, strict=True)
        ]
    return str(len(stated)), f"{brier:.3f}", *cells


def _by_worth(stated: Sequence[Stated]) -> list[str]:
    """How many claims of each probability by the line in force were right."""
    rows = by_probability(stated, _in_force(stated))
    told = [f"{low:g} to {high:g}: {right} of {count}" for low, high, right, count in rows]
    left = [one.right for one in stated if one.left > MOST]
    told += ["", f"more than half is left: {sum(left)} of {len(left)}"]
    return ["probability by the line in force: right", *told, *by_held_out(stated)]


def by_held_out(stated: Sequence[Stated]) -> list[str]:
    """How many names of `missing_physics` were right, by what held-out recordings say of each."""
    told = ["", "names of missing_physics whose share of what is held out"]
    for is_borne_out, words in ((True, "is surely above zero"), (False, "is not")):
        own = [s.right for s in stated if s.is_physics and s.is_borne_out == is_borne_out]
        told.append(f"  {words}: {sum(own)} of {len(own)} right")
    return told


def by_probability(
    stated: Sequence[Stated], probabilities: Sequence[float]
) -> list[tuple[float, float, int, int]]:
    """Ends of ranges of probabilities, how many claims in each were right, and of how many."""
    told, right = np.array(probabilities), np.array([one.right for one in stated])
    rows = []
    for low, high in pairwise((0.0, 0.5, 0.7, 0.8, 0.9, 0.95, 1.0)):
        own = (told >= low) & (told < high)
        if own.any():
            rows.append((low, high, int(right[own].sum()), int(own.sum())))
    return rows


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line: python -m tests.blind.draw.worth."""
    tell_of(__doc__, arguments, table)


if __name__ == "__main__":
    main()
