"""The report of a benchmark as text: bars, confusions, limits, costs, every failure."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from tests.blind.bars import bars
from tests.blind.by_effect import by_effect, failures
from tests.blind.limits import limits
from tests.blind.numbers_said import MODELS
from tests.blind.plan import SHARES
from tests.blind.probabilities import reliability
from tests.blind.score import Scored

GAIN_EDGES = (0.0, 15.0, 60.0, 250.0, 1e3, 1e4, np.inf)


def report(scores: Sequence[Scored], benchmark: Mapping[str, Any], more: Sequence[str] = ()) -> str:
    """Text of the whole report.

    Parameters
    ----------
    scores : sequence of Scored
        All cases that were run.
    benchmark : mapping
        `cases` and `seed`.
    more : sequence of str
        Further tables, such as those of baselines and placebos.
    """
    kinds = Counter(one.kind for one in scores)
    parts = [
        f"Blind benchmark: {len(scores)} of {benchmark['cases']} cases run, "
        f"seed {benchmark['seed']}",
        "Mix: " + ", ".join(f"{kinds[kind]} {kind}" for kind in SHARES),
        bars(scores),
        *more,
        _by_gain(scores),
        limits(scores),
        _unseen_runs(scores),
        reliability(scores),
        by_effect(scores),
        _places(scores),
        _names(scores),
        failures(scores),
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


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


def _unseen_runs(scores: Sequence[Scored]) -> str:
    """Median held-out error over the noise floor, by kind of case."""
    lines = [f"{'kind':<30}{'cases':>6}" + "".join(f"{model:>17}" for model in MODELS)]
    groups = {
        "named right": [s for s in scores if s.outcome == "right" and s.named],
        "owed, not named right": [s for s in scores if s.is_owed and s.outcome != "right"],
        "outside": [s for s in scores if s.kind == "outside"],
        "nothing to name": [s for s in scores if "null" in s.kind or s.kind == "decoy"],
    }
    for title, group in groups.items():
        known = [dict(s.numbers.held_out) for s in group if s.numbers.held_out]
        full = [one for one in known if set(one) == set(MODELS)]
        cells = (
            "".join(f"{np.median([one[model] for one in full]):>17.3g}" for model in MODELS)
            if full
            else ""
        )
        lines.append(f"{title:<30}{len(full):>6}{cells}")
    return "Error on held-out recordings over the noise floor, median\n" + "\n".join(lines)


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
