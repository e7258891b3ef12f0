"""A proposed experiment, or the result of a confirmation run, as lines of a terminal."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

from gmfbo.diagnosis.experiment.separation import ENOUGH
from gmfbo.diagnosis.result.predictions import said
from gmfbo.plain_words import WIDTH, number, percent, quantity, words, wrapped

if TYPE_CHECKING:
    from gmfbo.diagnosis.experiment.observed import Confirmation
    from gmfbo.diagnosis.experiment.proposal import ProposedExperiment

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
    lines += _entry("why", _purpose(proposed))
    for rival, seen in proposed.predicted.items():
        lines += _entry("predicted", f"{said(rival)}: {seen}")
    lines += _entry("shows", _sizes(proposed), 6)
    if proposed.hidden:
        told = "; ".join(f"{words(e.name)} ({e.why})" for e in proposed.hidden[:_EFFECTS])
        more = "; ..." if len(proposed.hidden) > _EFFECTS else ""
        lines += _entry("does not", f"{told}{more}")
    return [*lines, *_entry("written", written)]


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


def _purpose(proposed: ProposedExperiment) -> str:
    """What it does, and how surely rivals are told apart."""
    separation = proposed.separation
    if separation is None or not (apart := separation.told_apart):
        return f"it {proposed.why}"
    return (
        f"it {proposed.why}: log odds of at least {number(min(apart.values()))} nats are expected "
        f"for the true one, {number(ENOUGH)} are enough"
    )


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
            said(p.name),
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
