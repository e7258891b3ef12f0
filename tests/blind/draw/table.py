"""The table by which versions of the diagnosis are compared.

python -m tests.blind.draw.table OUTCOMES.jsonl [MORE.jsonl ...] [--text FILE] [--halves CASE]
"""

from __future__ import annotations

import argparse
import math
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tests.blind.draw.cases import SIZES
from tests.blind.draw.judging import PHYSICS_CLAIMED, Interval, Judged, judge
from tests.blind.draw.measures import (
    NORMAL,
    changed_odds,
    clopper_pearson,
    clustered_share,
    recalibration,
)
from tests.blind.draw.nulls import VARIANTS
from tests.blind.draw.outcomes import read_outcomes, tell


def table(judged: Sequence[Judged], halves: int | None = None) -> str:
    """Text of all tables.

    Parameters
    ----------
    judged : sequence of Judged
        The cases that were run.
    halves : int, optional
        First case of the second half, on which the line that the first half's odds ask for is
        tried.
    """
    parts = [
        _head(judged),
        _nulls([j for j in judged if j.stratum == "null"]),
        _named(judged),
        _by_size([j for j in judged if j.stratum == "owed"]),
        _outside([j for j in judged if j.stratum == "outside"]),
        _statements(judged),
        "" if halves is None else recalibrated(judged, halves),
        _intervals(judged),
        _error_left([j for j in judged if j.stratum == "owed" and j.is_owed]),
        _cost(judged),
        _failures(judged),
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def _head(judged: Sequence[Judged]) -> str:
    counts = Counter(j.stratum for j in judged)
    mix = ", ".join(f"{count} {stratum}" for stratum, count in counts.items())
    return f"{len(judged)} cases run: {mix}"


def _share(count: int, total: int) -> str:
    """`3 of 40   7.5 %  [1.6, 20.4] %`, the interval by Clopper and Pearson."""
    if not total:
        return "0 of 0"
    low, high = (100.0 * bound for bound in clopper_pearson(count, total))
    return f"{f'{count} of {total}':<11}{100.0 * count / total:5.1f} %  [{low:.1f}, {high:.1f}] %"


def _nulls(nulls: Sequence[Judged]) -> str:
    if not nulls:
        return ""
    columns = ("right", "told", "named", "outside", "failed")
    lines = [
        "Nulls",
        f"{'kind':<12}{'cases':>6}" + "".join(f"{c:>9}" for c in columns) + "   physics claimed",
    ]
    for kind in (*VARIANTS, "all"):
        own = [j for j in nulls if kind in ("all", j.family)]
        counts = Counter(j.outcome for j in own)
        ended = len(own) - counts["failed"]
        claimed = sum(counts[outcome] for outcome in PHYSICS_CLAIMED)
        cells = "".join(f"{counts[c]:>9}" for c in columns)
        lines.append(f"{kind:<12}{len(own):>6}{cells}   {_share(claimed, ended)}")
    return "\n".join(lines)


def _named(judged: Sequence[Judged]) -> str:
    """Owed names, pairs and decoys."""
    columns = ("right", "set", "partial", "missed", "wrong", "failed")
    lines = [f"{'named':<18}{'cases':>6}" + "".join(f"{c:>9}" for c in columns)]
    for stratum in ("owed", "pair"):
        own = [j for j in judged if j.stratum == stratum and j.is_owed]
        counts = Counter(j.outcome for j in own)
        lines.append(f"{stratum:<18}{len(own):>6}" + "".join(f"{counts[c]:>9}" for c in columns))
    owed = [j for j in judged if j.stratum == "owed" and j.is_owed]
    decoys = [j for j in judged if j.stratum == "decoy"]
    claimed = sum(j.outcome in PHYSICS_CLAIMED for j in decoys)
    right = sum(j.outcome == "right" for j in owed)
    either = sum(j.outcome in ("right", "set") for j in owed)
    lines += [
        f"{'owed, right':<34}{_share(right, len(owed))}",
        f"{'owed, right or an honest set':<34}{_share(either, len(owed))}",
        f"{'decoys with physics claimed':<34}{_share(claimed, len(decoys))}",
    ]
    return "\n".join(lines)


def _by_size(owed: Sequence[Judged]) -> str:
    lines = [f"{'owed, by size':<18}{'cases':>6}{'right':>9}{'set':>9}"]
    for size in (*(name for _, name in SIZES), "huge"):
        own = Counter(j.outcome for j in owed if j.size == size)
        if own:
            lines.append(f"{size:<18}{own.total():>6}{own['right']:>9}{own['set']:>9}")
    return "\n".join(lines) if owed else ""


def _outside(outside: Sequence[Judged]) -> str:
    ended = [j for j in outside if j.outcome != "failed"]
    verdict = sum(j.verdict == "outside_library" for j in ended)
    false = sum(bool(j.false_names) for j in ended)
    laws = len({j.hidden for j in outside})
    return "\n".join(
        [
            f"Outside the library, {laws} laws",
            f"{'verdict':<34}{_share(verdict, len(ended))}",
            f"{'false names':<34}{_share(false, len(ended))}",
        ]
    )


def _statements(judged: Sequence[Judged]) -> str:
    """False names in all cases, sizes of sets, and how sure the statements were."""
    ended = [j for j in judged if j.outcome != "failed"]
    false = sum(bool(j.false_names) for j in ended)
    claims = [claim for j in ended for claim in j.claims]
    sets = [len(claim.members) for claim in claims]
    rivalled = sum(size > 1 for size in sets)
    lines = [
        f"{'cases with a false name':<34}{_share(false, len(ended))}",
        f"{'statements told as a set':<34}{_share(rivalled, len(claims))}",
    ]
    if sets:
        lines.append(f"{'members of a statement, median':<34}{np.median(sets):.0f}")
    stated, right = _odds(judged)
    if stated:
        lines += _probabilities(stated, right)
    return "\n".join(lines)


def _odds(judged: Sequence[Judged]) -> tuple[list[float], list[bool]]:
    """What was stated of each claim, and whether it came true."""
    claims = [claim for j in judged if j.outcome != "failed" for claim in j.claims]
    stated = [c for c in claims if not math.isnan(c.probability)]
    return [c.probability for c in stated], [c.judged == "right" for c in stated]


def recalibrated(judged: Sequence[Judged], halves: int) -> str:
    """Odds of the second half of the cases, changed by the line that those of the first ask for.

    Parameters
    ----------
    judged : sequence of Judged
        All cases; their numbers are in random order.
    halves : int
        First case of the second half.
    """
    first, second = (
        _odds([j for j in judged if (int(j.case) >= halves) == late]) for late in (False, True)
    )
    line = recalibration(*first)
    if line is None:
        return "Stated odds: the first half of the cases tells no line"
    head = f"Odds of cases from {halves:03d} on, changed by the line of those before"
    lines = [head, *_probabilities(list(changed_odds(second[0], line[0])), second[1])]
    return "\n".join([*lines, f"{'that line':<34}{_line(line)}"])


def _probabilities(stated: Sequence[float], right: Sequence[bool]) -> list[str]:
    """Whether what was stated came true as often as it was stated."""
    p, y = np.array(stated), np.array(right, dtype=float)
    lines = [
        f"{'probability, mean; right; Brier':<34}{p.mean():.3f}; {y.mean():.3f}; "
        f"{np.mean((p - y) ** 2):.3f} on {len(p)}"
    ]
    fitted = recalibration(stated, right)
    if fitted:
        lines.append(f"{'recalibration: intercept; slope':<34}{_line(fitted)}")
    return lines


def _line(fitted: tuple[NDArray[np.float64], NDArray[np.float64]]) -> str:
    """Intercept and slope, each with its 95 % interval."""
    return "; ".join(
        f"{value:.2f} [{value - NORMAL * error:.2f}, {value + NORMAL * error:.2f}]"
        for value, error in zip(*fitted, strict=True)
    )


def _intervals(judged: Sequence[Judged]) -> str:
    """How many hold, with the exact interval, and the one that takes clusters for trials."""
    lines = [
        "Intervals of 95 % that hold the truth; clustered by machine and law; half width over the "
        "value, median"
    ]
    groups: dict[str, list[tuple[Interval, tuple[object, ...]]]] = {
        "laws": [],
        "twin's parameters": [],
    }
    for j in judged:
        effects = {f"{name}." for name in j.hidden}
        for interval in j.intervals:
            is_law = any(interval.name.startswith(effect) for effect in effects)
            kind = "laws" if is_law else "twin's parameters"
            groups[kind].append((interval, (j.machine, frozenset(j.hidden))))
    for title, own in (*groups.items(), ("both", [one for g in groups.values() for one in g])):
        held = [interval.holds for interval, _ in own]
        low, high = (100.0 * b for b in clustered_share(held, [cluster for _, cluster in own]))
        tail = f"; [{low:.1f}, {high:.1f}] %; {np.median([i.width for i, _ in own]):.3f}"
        lines.append(f"{title:<34}{_share(sum(held), len(own))}{tail if own else ''}")
    return "\n".join(lines)


def _error_left(owed: Sequence[Judged]) -> str:
    left = [j.error_left for j in owed if j.error_left is not None]
    if not left:
        return ""
    median, most = np.quantile(left, [0.5, 0.9])
    return (
        f"{'owed, explainable error left':<34}median {median:.2f}, 90 % {most:.2f} "
        f"on {len(left)} of {len(owed)}"
    )


def _cost(judged: Sequence[Judged]) -> str:
    ended = [j for j in judged if j.outcome != "failed"]
    if not ended:
        return ""
    rows = {
        "simulations": [j.simulations for j in ended],
        "seconds, wall clock": [j.seconds for j in ended],
        "seconds, all processes": [j.cpu_seconds for j in ended if not math.isnan(j.cpu_seconds)],
    }
    return "\n".join(
        f"{title:<34}median {np.median(own):.0f}, 90 % {np.quantile(own, 0.9):.0f}, "
        f"most {max(own):.0f}"
        for title, own in rows.items()
        if own
    )


def _failures(judged: Sequence[Judged]) -> str:
    """Each case that is not right, for reading."""
    lines = [
        f"{j.case} {j.machine} {j.told()}"
        for j in sorted(judged, key=lambda j: (j.stratum, j.case))
        if j.outcome not in ("right", "told")
    ]
    return "\n".join(["Not right", *lines]) if lines else ""


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line: python -m tests.blind.draw.table."""
    parser = argparse.ArgumentParser(
        description=(__doc__ or "").strip(), formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("outcomes", type=Path, nargs="+")
    parser.add_argument("--text", type=Path, help="file for the table")
    parser.add_argument("--halves", type=int, metavar="CASE", help="first case of the second half")
    given = parser.parse_args(arguments)
    lines = [line for path in given.outcomes for line in read_outcomes(path)]
    text = table([judge(line) for line in lines], given.halves)
    tell(text, given.text)


if __name__ == "__main__":
    main()
