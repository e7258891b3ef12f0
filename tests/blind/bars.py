"""The bars of the benchmark: what has to hold, and what was measured."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.stats import beta

from tests.blind.probabilities import brier_scores
from tests.blind.score import ABSTAIN, NOTHING_TO_NAME, Scored


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


def bars(scores: Sequence[Scored]) -> str:
    """Text: shares with their exact intervals, then medians."""
    owed = [s for s in scores if s.is_owed]
    alone = [s for s in owed if s.kind == "single"]
    pairs = [s for s in scores if s.kind == "pair"]
    faint = [s for s in scores if s.can_be_named and s.gain < ABSTAIN]
    between = [s for s in scores if s.can_be_named and ABSTAIN <= s.gain <= 60.0]
    quiet = [s for s in scores if s.kind in NOTHING_TO_NAME]
    outside = [s for s in scores if s.kind == "outside"]
    rows: list[tuple[str, Sequence[Scored], Callable[[Scored], bool], str]] = [
        ("gain > 60: named right", owed, _is_right, ">= 90 %"),
        ("  single effects alone", alone, _is_right, ""),
        ("  the very law", owed, lambda s: _is_right(s) and s.is_exact, ""),
        ("  a set that holds it instead", owed, lambda s: s.outcome == "set", ""),
        ("gain 15 to 60: right, set or none", between, lambda s: s.outcome != "wrong", ""),
        ("gain < 15: something named", faint, lambda s: bool(s.named), "<= 2 %"),
        ("nulls with a claim", quiet, lambda s: s.outcome == "wrong", "at most 1"),
        ("  stressed", _of(scores, "stressed_null"), lambda s: s.outcome == "wrong", "0"),
        ("  decoys", _of(scores, "decoy"), lambda s: s.outcome == "wrong", "0"),
        ("wrong names, all cases", scores, lambda s: s.outcome == "wrong", "<= 2 %"),
        ("signal path right, of the named", _judged(scores, "path"), _path_is_right, ">= 90 %"),
        ("region and times right", _judged(scores, "place"), _place_is_right, ">= 85 %"),
        ("pairs with both named", pairs, _has_both, ">= 85 %"),
        ("  where each adds > 60", [s for s in pairs if s.is_owed], _has_both, ""),
        ("outside: verdict", outside, lambda s: s.verdict == "outside_library", ">= 85 %"),
        ("outside: false names", outside, lambda s: s.has_false_name, "<= 5 %"),
        ("no port for it: something named", _unreachable(scores), lambda s: bool(s.named), "0"),
        ("failed runs", scores, lambda s: s.outcome == "failed", "0"),
    ]
    lines = [f"{'bar':<36}{'count':>12}{'share':>9}   95 %             asked"]
    for title, chosen, test, asked in rows:
        count = sum(test(one) for one in chosen)
        low, high = clopper_pearson(count, len(chosen))
        share = f"{100.0 * count / len(chosen):.1f} %" if chosen else "-"
        lines.append(
            f"{title:<36}{f'{count} of {len(chosen)}':>12}{share:>9}"
            f"   [{100 * low:5.1f}, {100 * high:5.1f}] %  {asked}".rstrip()
        )
    return "\n".join([*lines, "", *_medians(scores)])


def _medians(scores: Sequence[Scored]) -> list[str]:
    right = [s for s in scores if s.outcome == "right" and s.named]
    ended = [s for s in scores if s.outcome != "failed"]
    errors = [(name, e) for s in right for name, e in s.numbers.errors]
    gaps = [e for name, e in errors if name == "backlash.gap"]
    others = [e for name, e in errors if name != "backlash.gap"]
    twin = [e for s in ended for _, e in s.numbers.twin_errors if s.outcome == "right"]
    rows = [
        ("explainable error removed", _known([s.removed for s in right]), ">= 0.9"),
        ("error of an effect's parameter", others, "<= 0.10"),
        ("error of the backlash's gap", gaps, "<= 0.30"),
        ("error of the twin's parameters", twin, ""),
        ("simulations", [s.simulations for s in ended], ""),
        ("seconds, wall clock", [s.seconds for s in ended], ""),
    ]
    lines = [f"{'median':<36}{'values':>8}{'median':>10}{'90 %':>10}{'largest':>10}   asked"]
    for title, values, asked in rows:
        cells = [np.median(values), np.quantile(values, 0.9), np.max(values)] if values else []
        shown = "".join(f"{cell:>10.4g}" for cell in cells) or f"{'-':>10}{'':>20}"
        lines.append(f"{title:<36}{len(values):>8}{shown}   {asked}".rstrip())
    for title, flags, asked in (
        (
            "95 % intervals that hold: effects",
            [held for s in right for _, held in s.numbers.covered],
            ">= 85 %",
        ),
        (
            "95 % intervals that hold: twin",
            [held for s in ended for _, held in s.numbers.twin_covered if s.outcome == "right"],
            "",
        ),
    ):
        share = f"{100.0 * np.mean(flags):.1f} %" if flags else "-"
        lines.append(f"{title:<36}{len(flags):>8}{share:>10}{'':>23}{asked}".rstrip())
    return [*lines, "", brier_scores(scores)]


def _known(values: Sequence[float | None]) -> list[float]:
    return [value for value in values if value is not None]


def _of(scores: Sequence[Scored], kind: str) -> list[Scored]:
    return [one for one in scores if one.kind == kind]


def _unreachable(scores: Sequence[Scored]) -> list[Scored]:
    return [one for one in scores if not one.within_reach]


def _judged(scores: Sequence[Scored], what: str) -> list[Scored]:
    return [s for s in scores if (s.path_right if what == "path" else s.place_right) is not None]


def _is_right(one: Scored) -> bool:
    return one.outcome == "right"


def _has_both(one: Scored) -> bool:
    return one.outcome == "right" or (one.outcome == "set" and len(one.named) == 2)


def _path_is_right(one: Scored) -> bool:
    return bool(one.path_right)


def _place_is_right(one: Scored) -> bool:
    return bool(one.place_right)
