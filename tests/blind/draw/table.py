"""The table by which versions of the diagnosis are compared.

python -m tests.blind.draw.table OUTCOMES.jsonl [MORE.jsonl ...] [--text FILE]
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence

import numpy as np

from tests.blind.draw.cases import SIZES
from tests.blind.draw.judging import PHYSICS_CLAIMED, Interval, Judged, judge
from tests.blind.draw.measures import NORMAL, clopper_pearson, clustered_share, recalibration
from tests.blind.draw.nulls import VARIANTS
from tests.blind.draw.outcomes import tell_of


def table(judged: Sequence[Judged]) -> str:
    """Text of all tables.

    Parameters
    ----------
    judged : sequence of Judged
        The cases that were run.
    """
    parts = [
        _head(judged),
        _nulls([j for j in judged if j.stratum == "null"]),
        _named(judged),
        _by_size([j for j in judged if j.stratum == "owed"]),
        _outside([j for j in judged if j.stratum == "outside"]),
        _statements(judged),
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
    stated = [c for c in claims if not math.isnan(c.probability)]
    if stated:
        lines += _probabilities(
            [c.probability for c in stated], [c.judged == "right" for c in stated]
        )
    return "\n".join(lines)


def _probabilities(stated: Sequence[float], right: Sequence[bool]) -> list[str]:
    """Whether what was stated came true as often as it was stated."""
    p, y = np.array(stated), np.array(right, dtype=float)
    lines = [
        f"{'probability, mean; right; Brier':<34}{p.mean():.3f}; {y.mean():.3f}; "
        f"{np.mean((p - y) ** 2):.3f} on {len(p)}"
    ]
    fitted = recalibration(stated, right)
    if fitted:
        cells = [
            f"{value:.2f} [{value - NORMAL * error:.2f}, {value + NORMAL * error:.2f}]"
            for value, error in zip(*fitted, strict=True)
        ]
        lines.append(f"{'recalibration: intercept; slope':<34}{'; '.join(cells)}")
    return lines


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
    tell_of(__doc__, arguments, lambda lines: table([judge(line) for line in lines]))


if __name__ == "__main__":
    main()
