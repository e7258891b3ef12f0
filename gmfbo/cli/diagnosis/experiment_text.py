"""A proposed experiment, or the result of a confirmation run, as lines of a terminal."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from gmfbo.plain_words import WIDTH, number, percent, quantity, words, wrapped

if TYPE_CHECKING:
    from gmfbo.diagnosis.experiment.observed import Confirmation
    from gmfbo.diagnosis.experiment.proposal import ProposedExperiment
    from gmfbo.diagnosis.experiment.separation import Separation

INDENT = 13
_EFFECTS = 6  # effects listed with their sizes


def _entry(head: str, text: str, most: int = 4) -> list[str]:
    return wrapped(text, f"{head:<{INDENT}}", most)


def experiment_lines(proposed: ProposedExperiment, written: str) -> list[str]:
    """Lines of a proposal: motion, extremes, detectable effects and predictions."""
    recording = proposed.recording
    seconds = float(recording.time[-1] - recording.time[0])
    (name,) = recording.signals
    lines = _entry("play", f"{proposed.words}: {name} over {seconds:.3g} s")
    lines += _limit_lines(proposed)
    lines += _purpose(proposed)
    for rival, seen in proposed.predicted.items():
        lines += _entry("predicted", f"{_said(rival)}: {seen}")
    lines += _entry("shows", _sizes(proposed), 6)
    if proposed.hidden:
        told = "; ".join(f"{words(e.name)} ({e.why})" for e in proposed.hidden[:_EFFECTS])
        more = "; ..." if len(proposed.hidden) > _EFFECTS else ""
        lines += _entry("does not", f"{told}{more}")
    return [*lines, *_entry("written", written)]


def _said(name: str) -> str:
    from gmfbo.diagnosis.experiment.observed import said

    return said(name)


def _limit_lines(proposed: ProposedExperiment) -> list[str]:
    peaks, limits = proposed.peaks, proposed.limits
    unit = (
        "m" if proposed.recording.units.get(next(iter(proposed.recording.signals))) == "m" else ""
    )
    told = [
        f"position {number(peaks.low)} to {number(peaks.high)} of "
        f"{limits.low:g} to {limits.high:g}{' ' + unit if unit else ''}"
    ]
    for name, value in peaks.rates.items():
        bound = limits.rate(name)
        if math.isfinite(bound):
            told.append(f"{name} {number(value)} of {bound:g}")
    if peaks.torque is None:
        told.append("torque not known to the twin")
    elif math.isfinite(limits.torque):
        told.append(f"torque {number(peaks.torque)} of {limits.torque:g} {peaks.torque_unit}")
    else:
        told.append(f"torque {quantity(peaks.torque, peaks.torque_unit)}, no limit was given")
    return _entry("reaches", "; ".join(told))


def _purpose(proposed: ProposedExperiment) -> list[str]:
    if proposed.separation is not None:
        return _entry("why", _separation(proposed.separation))
    if proposed.wanted:
        names = ", ".join(words(name) for name in proposed.wanted)
        return _entry("why", f"it shows best what was not excited: {names}")
    return _entry("why", "of the menu it shows most effects at the smallest sizes")


def _separation(separation: Separation) -> str:
    """Which rivals it tells apart, how surely, and which not."""
    from gmfbo.diagnosis.experiment.separation import ENOUGH

    def listed(pairs: Iterable[tuple[str, str]]) -> str:
        return "; ".join(f"{_said(a)} from {_said(b)}" for a, b in pairs)

    apart = separation.told_apart()
    together = [pair for pair in separation.log_odds if pair not in apart]
    if not apart:
        pair, largest = max(separation.log_odds.items(), key=lambda one: one[1])
        return (
            f"it tells no two apart, {listed([pair])} most nearly: log odds of {number(largest)} "
            f"nats are expected, {number(ENOUGH)} would be enough"
        )
    told = (
        f"it tells {listed(apart)}: log odds of at least {number(min(apart.values()))} nats are "
        f"expected for the true one, {number(ENOUGH)} are enough"
    )
    return f"{told}; it does not tell {listed(together)}" if together else told


def _sizes(proposed: ProposedExperiment) -> str:
    names = proposed.wanted or tuple(proposed.shows)
    told = [
        f"{words(name)} from {quantity(proposed.shows[name].size, proposed.shows[name].unit)}"
        for name in names[:_EFFECTS]
    ]
    rest = len(proposed.shows) - len(told)
    return "; ".join(told) + (f"; and {rest} more effects" if rest > 0 else "")


def confirmation_lines(confirmation: Confirmation, written: str) -> list[str]:
    """The sentence, and a table of predicted against observed."""
    start, end = confirmation.scored
    lines = [*textwrap.wrap(confirmation.sentence, WIDTH), ""]
    signals = list(confirmation.best.nrmse)
    head = ["predicted by", *(words(name) for name in signals), "distance", "behind by"]
    rows = [
        [
            _said(p.name),
            *(percent(p.nrmse[name]) for name in signals),
            number(p.per_residual),
            number(confirmation.behind(p)) if p is not confirmation.best else "-",
        ]
        for p in confirmation.predictions
    ]
    lines += _table([head, *rows])
    lines += _entry(
        "",
        f"error over range, of {start:.3g} to {end:.3g} s; distance is chi2 for each residual, 1 "
        f"where nothing is left; {number(confirmation.threshold)} behind tells two apart",
    )
    if math.isfinite(confirmation.removed):
        share = percent(confirmation.removed)
        lines += _entry("removed", f"{share} of what the refitted twin alone leaves, by the first")
    return [*lines, *_entry("written", written)]


def _table(rows: Sequence[Sequence[str]]) -> list[str]:
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return [
        "  ".join(
            cell.ljust(width) if i == 0 else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        for row in rows
    ]
