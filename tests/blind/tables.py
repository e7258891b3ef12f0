"""The report of a benchmark as text: bars, confusions, limits, costs, every failure."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.stats import beta

from tests.blind.plan import SHARES
from tests.blind.score import NOTHING_TO_NAME, Scored, family

GAIN_EDGES = (0.0, 15.0, 60.0, 250.0, 1e3, 1e4, 1e5, np.inf)
PROBABILITY_EDGES = (0.0, 0.5, 0.7, 0.8, 0.9, 0.95, 1.0001)


def clopper_pearson(count: int, total: int, level: float = 0.95) -> tuple[float, float]:
    """Exact interval of a share (Clopper, Pearson 1934), both tails alike.

    Parameters
    ----------
    count, total : int
        Successes, and trials.
    level : float
        Coverage.
    """
    if total == 0:
        return 0.0, 1.0
    tail = 0.5 * (1.0 - level)
    low = float(beta.ppf(tail, count, total - count + 1)) if count else 0.0
    high = float(beta.ppf(1.0 - tail, count + 1, total - count)) if count < total else 1.0
    return low, high


def report(scores: Sequence[Scored], benchmark: Mapping[str, Any]) -> str:
    """Text of the whole report.

    Parameters
    ----------
    scores : sequence of Scored
        All cases that were run.
    benchmark : mapping
        `cases` and `seed`.
    """
    parts = [
        f"Blind benchmark: {len(scores)} of {benchmark['cases']} cases run, "
        f"seed {benchmark['seed']}",
        "Mix: " + ", ".join(f"{_count(scores, kind)} {kind}" for kind in SHARES),
        _bars(scores),
        _by_gain(scores),
        _names(scores),
        _places(scores),
        _reliability(scores),
        _costs(scores),
        _failures(scores),
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def _count(scores: Sequence[Scored], kind: str) -> int:
    return sum(one.kind == kind for one in scores)


def _bars(scores: Sequence[Scored]) -> str:
    """What has to hold, and what was measured."""
    hidden = [s for s in scores if s.kind in ("single", "pair") and s.within_reach]
    clear = [s for s in hidden if s.gain > 60.0]
    faint = [s for s in hidden if s.gain < 15.0]
    nulls = [s for s in scores if s.kind in ("null", "stressed_null")]
    quiet = [s for s in scores if s.kind in NOTHING_TO_NAME]
    named = [s for s in scores if s.path_right is not None]
    placed = [s for s in scores if s.place_right is not None]
    rows: list[tuple[str, Sequence[Scored], Callable[[Scored], bool], str]] = [
        ("gain > 60: named right", clear, lambda s: s.outcome == "right", ">= 85 %"),
        ("gain > 60: right or in the set", clear, lambda s: s.outcome in ("right", "set"), ""),
        ("gain < 15: something named", faint, lambda s: bool(s.named), "0"),
        ("nulls with a claim", nulls, lambda s: bool(s.named), "0"),
        ("nulls and decoys with a claim", quiet, lambda s: bool(s.named), ""),
        ("wrong names, all cases", scores, lambda s: s.outcome == "wrong", "<= 4 %"),
        ("signal path right, of the named", named, lambda s: bool(s.path_right), ">= 85 %"),
        ("state and times right", placed, lambda s: bool(s.place_right), ">= 80 %"),
        ("outside the catalogue flagged", _of(scores, "outside"), _is_right, ""),
        ("failed runs", scores, lambda s: s.outcome == "failed", "0"),
    ]
    lines = [f"{'bar':<34}{'count':>12}{'share':>9}   95 %             asked"]
    for title, chosen, test, asked in rows:
        count = sum(test(one) for one in chosen)
        low, high = clopper_pearson(count, len(chosen))
        share = f"{100.0 * count / len(chosen):.1f} %" if chosen else "-"
        lines.append(
            f"{title:<34}{f'{count} of {len(chosen)}':>12}{share:>9}"
            f"   [{100 * low:5.1f}, {100 * high:5.1f}] %  {asked}".rstrip()
        )
    return "\n".join(lines)


def _of(scores: Sequence[Scored], kind: str) -> list[Scored]:
    return [one for one in scores if one.kind == kind]


def _is_right(one: Scored) -> bool:
    return one.outcome == "right"


def _by_gain(scores: Sequence[Scored]) -> str:
    """Outcomes of single effects by the oracle's gain."""
    outcomes = ("right", "set", "partial", "wrong", "missed", "failed")
    lines = [f"{'oracle gain':<20}{'cases':>6}" + "".join(f"{name:>9}" for name in outcomes)]
    singles = [s for s in scores if s.kind == "single" and s.within_reach]
    for low, high in pairwise(GAIN_EDGES):
        chosen = [s for s in singles if low <= s.gain < high]
        counts = Counter[str](s.outcome for s in chosen)
        cells = "".join(f"{counts[name]:>9}" for name in outcomes)
        lines.append(f"{f'{low:g} to {high:g}':<20}{len(chosen):>6}{cells}")
    return "Single effects by the oracle's gain over parameters alone\n" + "\n".join(lines)


def _names(scores: Sequence[Scored]) -> str:
    """Hidden against named, of all cases."""
    pairs = Counter(
        (
            " + ".join(sorted(s.hidden)) if s.kind != "outside" else f"outside: {s.hidden[0]}",
            " + ".join(sorted(s.named))
            or ("(outside)" if s.verdict == "outside_library" else f"({s.verdict or 'failed'})"),
        )
        for s in scores
    )
    lines = [f"{'hidden':<50}{'named':<56}{'cases':>6}"]
    lines += [
        f"{true or '(nothing)':<50}{said:<56}{n:>6}" for (true, said), n in sorted(pairs.items())
    ]
    return "Names\n" + "\n".join(lines)


def _places(scores: Sequence[Scored]) -> str:
    """True signal path against the one said, where something was named."""
    chosen = [s for s in scores if s.kind == "single" and s.named]
    paths = ("controller", "actuator", "plant", "transmission", "sensor", "none")
    counts = Counter((s.true_path, s.said_path) for s in chosen)
    lines = [f"{'true path, said:':<18}" + "".join(f"{path:>14}" for path in paths)]
    for true in paths[1:-1]:
        lines.append(f"{true:<18}" + "".join(f"{counts[true, said]:>14}" for said in paths))
    return "Places, of single effects with a name\n" + "\n".join(lines)


def _reliability(scores: Sequence[Scored]) -> str:
    claims = [claim for s in scores if s.kind != "outside" for claim in s.claims]
    lines = [f"{'probability':<16}{'claims':>7}{'mean':>8}{'right':>8}"]
    for low, high in pairwise(PROBABILITY_EDGES):
        chosen = [(p, right) for p, right in claims if low <= p < high]
        if chosen:
            mean, right = np.mean([p for p, _ in chosen]), np.mean([r for _, r in chosen])
            label = f"{low:g} to {min(high, 1.0):g}"
            lines.append(f"{label:<16}{len(chosen):>7}{mean:>8.2f}{right:>8.2f}")
    return "Reliability of the stated probability\n" + "\n".join(lines)


def _costs(scores: Sequence[Scored]) -> str:
    done = [s for s in scores if s.outcome != "failed"]
    if not done:
        return ""
    rows = [
        ("simulations", [s.simulations for s in done]),
        ("seconds, wall clock", [s.seconds for s in done]),
        (
            "explainable error removed",
            [s.removed for s in done if s.removed is not None and s.outcome == "right"],
        ),
        (
            "|inertia error|",
            [
                abs(s.inertia_error)
                for s in done
                if s.inertia_error is not None and s.outcome == "right"
            ],
        ),
    ]
    lines = [f"{'of runs that ended':<28}{'cases':>6}{'median':>10}{'90 %':>10}{'largest':>10}"]
    for title, values in rows:
        if values:
            cells = [np.median(values), np.quantile(values, 0.9), np.max(values)]
            lines.append(f"{title:<28}{len(values):>6}" + "".join(f"{c:>10.4g}" for c in cells))
    return "\n".join(lines)


def _failures(scores: Sequence[Scored]) -> str:
    """Every case that is not as it should be, one line each."""
    lines = []
    for s in scores:
        below = s.kind in ("single", "pair") and s.gain <= 60.0
        fine = s.outcome == "right" or (s.outcome == "missed" and below)
        if fine and s.path_right is not False and s.place_right is not False:
            continue
        faults: list[str] = [s.outcome] if not fine else []
        faults += ["path"] if s.path_right is False else []
        faults += ["place"] if s.place_right is False else []
        same = (
            " (same family)" if {family(n) for n in s.named} & {family(n) for n in s.hidden} else ""
        )
        lines.append(
            f"{s.case} {s.kind:<14}{s.machine:<20}gain {s.gain:<10.4g}"
            f"hidden {' + '.join(s.hidden) or '-'}; named {' + '.join(s.named) or '-'}{same}; "
            f"verdict {s.verdict or '-'}: {', '.join(faults)}" + (f" ({s.note})" if s.note else "")
        )
    return "Not as it should be\n" + "\n".join(lines or ["nothing"])
