"""The tool beside its baselines, by the same rules."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tests.blind.baselines import baseline_path
from tests.blind.score import NOTHING_TO_NAME, Scored, family


@dataclass(frozen=True)
class Entry:
    """What one method said of one case.

    Attributes
    ----------
    score : Scored
        The case.
    names : tuple of str
        Given by the method.
    ratio : float or None
        Held-out error over that of the parameters alone; None where the method has no model.
    simulations, seconds : float or None
        Its cost; None where it was not measured.
    """

    score: Scored
    names: tuple[str, ...] = ()
    ratio: float | None = None
    simulations: float | None = None
    seconds: float | None = None

    @property
    def is_right(self) -> bool:
        """All hidden effects by name or family, and nothing else."""
        true = {family(name) for name in self.score.hidden}
        return bool(self.names) and {family(name) for name in self.names} == true

    @property
    def is_wrong(self) -> bool:
        """A name that is not hidden, or where nothing can be named."""
        if not self.score.can_be_named:
            return bool(self.names)
        true = {family(name) for name in self.score.hidden}
        return any(family(name) not in true for name in self.names)


def baseline_table(out: Path, scores: Sequence[Scored]) -> str:
    """Text: a line a method; of brute force also this tool on the same cases."""
    ended = [s for s in scores if s.outcome != "failed"]
    known = {
        s.case: json.loads(baseline_path(out, s.case).read_text(encoding="utf-8"))
        for s in ended
        if baseline_path(out, s.case).exists()
    }
    brute = [s for s in ended if "brute" in known.get(s.case, {})]
    rows = [
        ("gmfbo", [_own(s) for s in ended]),
        ("nominal twin", [Entry(s, ratio=_ratio(s, "nominal")) for s in ended]),
        ("parameters only", [Entry(s, ratio=1.0) for s in ended]),
        ("unnamed spline", [Entry(s, ratio=_ratio(s, "unnamed_spline")) for s in ended]),
        ("Gaussian process", _entries(ended, known, "gp")),
        ("sparse regression", _entries(ended, known, "sparse")),
        ("brute force", _entries(brute, known, "brute")),
        ("gmfbo, same cases", [_own(s) for s in brute]),
    ]
    head = (
        f"{'method':<20}{'cases':>6}{'owed':>6}{'right':>7}{'wrong':>7}{'nulls':>7}{'claims':>8}"
        f"{'error':>8}{'runs':>7}{'seconds':>9}"
    )
    note = (
        "Methods: owed names and how many were right, wrong names in all cases, claims in nulls;\n"
        "of owed cases the median held-out error over that of the parameters alone; median cost"
    )
    return "\n".join([note, head, *(_row(title, entries) for title, entries in rows if entries)])


def _row(title: str, entries: Sequence[Entry]) -> str:
    owed = [e for e in entries if e.score.is_owed]
    nulls = [e for e in entries if e.score.kind in NOTHING_TO_NAME]
    ratios = [e.ratio for e in owed if e.ratio is not None]
    runs = [e.simulations for e in entries if e.simulations is not None]
    seconds = [e.seconds for e in entries if e.seconds is not None]
    return (
        f"{title:<20}{len(entries):>6}{len(owed):>6}{sum(e.is_right for e in owed):>7}"
        f"{sum(e.is_wrong for e in entries):>7}{len(nulls):>7}"
        f"{sum(bool(e.names) for e in nulls):>8}"
        f"{_median(ratios, '.2f'):>8}{_median(runs, '.0f'):>7}{_median(seconds, '.1f'):>9}"
    )


def _own(s: Scored) -> Entry:
    best = _ratio(s, "augmented") if s.named else 1.0
    return Entry(s, s.named, best, s.simulations, s.seconds)


def _ratio(s: Scored, model: str) -> float | None:
    errors = dict(s.numbers.held_out)
    if model not in errors or "parameters_only" not in errors:
        return None
    return errors[model] / errors["parameters_only"]


def _entries(scores: Sequence[Scored], known: dict[str, dict], method: str) -> list[Entry]:  # type: ignore[type-arg]
    found = [(s, known[s.case][method]) for s in scores if method in known.get(s.case, {})]
    return [
        Entry(
            s,
            tuple(said.get("names", ())),
            said.get("ratio"),
            said.get("simulations"),
            said.get("seconds"),
        )
        for s, said in found
    ]


def _median(values: Sequence[float], spec: str) -> str:
    return format(float(np.median(values)), spec) if values else "-"
