"""Remarks on the real runs of a study, which its best gains alone do not tell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gmfbo.objective.limits import Limits
from gmfbo.objective.margins import AT_LEAST
from gmfbo.objective.metric_words import MetricWords
from gmfbo.objective.settled import LATE_SHARE
from gmfbo.plain_words import number, words
from gmfbo.recordings.recording import Trajectory
from gmfbo.recordings.store.trial import Trial
from gmfbo.space import GainSpace
from gmfbo.tuning.history.incumbent import has_settled, runs_at
from gmfbo.tuning.study_file.study_sections import BudgetSection, StudyFile

AT_BOUND = 0.01
"""Share of a gain's range, as it is searched, within which a gain lies at its bound."""


WORTH = "worth"
"""Event that a further run is expected to gain less than the noise of one run."""


def remarks_on(
    study: StudyFile,
    real: Sequence[Trial],
    best: Trial | None,
    space: GainSpace,
    told: MetricWords,
) -> tuple[str, ...]:
    """Sentences on failed runs, limits that no run meets, metrics without effect, and bounds.

    Parameters
    ----------
    study : StudyFile
        With objective and limits.
    real : sequence of Trial
        Real runs, in order.
    best : Trial or None
        Best of them.
    space : GainSpace
        Box of the tuned gains, of which a reader of the study may not know all.
    told : MetricWords
        Words for the metrics.
    """
    limits, finished = Limits(study.constraints), [t for t in real if t.status == "ok"]
    found = [*_failed(real), *_unsettled(finished)]
    found += _never_met(finished, limits, told)
    found += _without_effect(finished, study.objective.weights, told)
    if best is not None:
        found += _beaten_by_settling(best, finished, limits)
        found += _noise_beyond_band(study, best)
        found += _at_bounds(best, space)
    return tuple(found)


def _noise_beyond_band(study: StudyFile, best: Trial) -> list[str]:
    """Where a run settled by its smoothed error, and its samples leave the band to the end."""
    horizon = study.reference.horizon
    value = best.metrics.get("settling_time", 0.0)
    if not has_settled(best) or value < (1.0 - LATE_SHARE) * horizon or len(study.references) > 1:
        return []
    signal, band = words(study.objective.signal), 100.0 * study.objective.band
    return [
        f"the noise of {signal} leaves the band of {band:g} % until the end, so that the settling "
        "time tells of the noise; widen [objective] band or set its filter"
    ]


def unmet_limits(
    gains: Mapping[str, float], real: Sequence[Trial], limits: Limits, told: MetricWords
) -> tuple[str, ...]:
    """What to say of recommended gains whose newest run does not meet the limits.

    Parameters
    ----------
    gains : mapping of str to float
        All gains by name [unit of the FMU parameter].
    real : sequence of Trial
        Real runs, in order.
    limits : Limits
        On metrics.
    told : MetricWords
        Words for the metrics.

    Returns
    -------
    tuple of str
        Empty where all limits are met, or none is stated.
    """
    if not limits:
        return ()
    runs = [trial for trial in runs_at(gains, real) if trial.status == "ok"]
    if not runs:
        return ("no run with these gains succeeded, so it is not known if they meet the limits",)
    metrics, found = runs[-1].metrics, []
    for name, value in limits.limited(metrics).items():
        if not float(value) <= limits.most[name]:
            has = float(value) * (-1.0 if name in AT_LEAST else 1.0)
            text = "not measured" if np.isnan(has) else told.text(name, has)
            found.append(f"does not meet the limit {_limit(name, limits)}: {text}")
    return tuple(found)


def ended_early(budget: BudgetSection, queries: int, made: int) -> list[str]:
    """Remark that a study ended before its real runs, since its queries are used up.

    Parameters
    ----------
    budget : BudgetSection
        Of the study.
    queries : int
        Queries of either source after the initial runs.
    made : int
        Real runs of this study.
    """
    if budget.is1_runs is None or made >= budget.is1_runs or queries < budget.most_queries:
        return []
    return [
        f"only {made} of {budget.is1_runs} real runs were made: no query is left (iterations = "
        f"{budget.most_queries}, of twin and axis); for more, raise iterations in [budget]"
    ]


def not_worth(gain: float, noise: float) -> str:
    """Sentence that a further run is expected to gain less [g] than the noise of one run [g]."""
    return (
        f"a further run is expected to gain {number(gain, 2)}, less than the noise of one run "
        f"({number(noise, 2)})"
    )


def worth_remarks(events: Sequence[Mapping[str, Any]]) -> list[str]:
    """Remark for the end of a study, where the last query was expected to gain next to nothing.

    Parameters
    ----------
    events : sequence of mapping
        Of the study's log.
    """
    asked = [event["number"] for event in events if event["event"] == "ask"]
    told = [event for event in events if event["event"] == WORTH]
    if not told or not asked or told[-1]["number"] != asked[-1]:
        return []
    runs = sum(one["confirms"] for one in told)
    confirmed = {0: "", 1: "; the last run repeated the recommended gains"}.get(
        runs, f"; {runs} runs repeated the recommended gains"
    )
    return [not_worth(told[-1]["gain"], told[-1]["noise"]) + confirmed]


def last_failure(real: Sequence[Trial]) -> str:
    """Why the last run that failed did; empty without one."""
    for trial in reversed(real):
        if trial.status != "ok":
            run = trial.recording
            return (run.message if isinstance(run, Trajectory) else "") or trial.status
    return ""


def _failed(real: Sequence[Trial]) -> list[str]:
    unsafe = sum(trial.status == "unsafe" for trial in real)
    failed = sum(trial.status != "ok" for trial in real) - unsafe
    counts = [
        f"{count} of {len(real)} real runs {what}"
        for count, what in ((failed, "failed"), (unsafe, "left the safety envelope"))
        if count
    ]
    return [f"{', '.join(counts)}; the last one: {last_failure(real)}"] if counts else []


def _unsettled(finished: Sequence[Trial]) -> list[str]:
    moving = sum(not has_settled(trial) for trial in finished)
    if not 0 < moving < len(finished):
        return []  # that none settled is said before all else
    return [f"{moving} of {len(finished)} runs that ended well did not settle; they rank below"]


def _never_met(finished: Sequence[Trial], limits: Limits, told: MetricWords) -> list[str]:
    found = []
    for name, most in limits.most.items():
        values = [float(limits.limited(trial.metrics)[name]) for trial in finished]
        measured = [value for value in values if not np.isnan(value)]
        if measured and min(measured) > most:
            # A margin has a least value, and is compared with a minus.
            nearest = min(measured) * (-1.0 if name in AT_LEAST else 1.0)
            has = "all have" if told.is_never(name, nearest) else "the nearest has"
            found.append(
                f"no run meets the limit {_limit(name, limits)}; {has} {told.text(name, nearest)}"
            )
    if finished and not found and not any(limits.met(trial.metrics) for trial in finished):
        found.append("no run meets all limits of [constraints] at once")
    return found


def _beaten_by_settling(best: Trial, finished: Sequence[Trial], limits: Limits) -> list[str]:
    if limits.met(best.metrics) or not any(limits.met(trial.metrics) for trial in finished):
        return []  # that no run meets them is said already
    return [
        "the best run does not meet all limits of [constraints]; a run that does has not settled, "
        "or is from before the plant changed"
    ]


def _limit(name: str, limits: Limits) -> str:
    return f"{words(name)} {'>=' if name in AT_LEAST else '<='} {limits.stated[name]:g}"


def _without_effect(
    finished: Sequence[Trial], weights: Mapping[str, float], told: MetricWords
) -> list[str]:
    counted = [name for name, weight in weights.items() if weight > 0.0]
    if len(finished) < 2:
        return []
    values = {
        # A metric is NaN, or lacks, where its signal was not recorded.
        name: np.unique([float(trial.metrics.get(name, np.nan)) for trial in finished])
        for name in counted
    }
    same = [name for name in counted if len(values[name]) == 1]
    if same and len(same) == len(counted):
        return [
            f"all {len(finished)} runs score the same, so no gains are better than others; check "
            "[reference] and [objective]: the unit and size of the step, the horizon, the signal"
        ]
    found = []
    for name in same:
        value = float(values[name][0])
        was = (
            f"was {told.text(name, value)} in all"
            if np.isfinite(value)
            else "was not measured in any of the"
        )
        found.append(f"{words(name)} {was} {len(finished)} runs, so it had no say")
    return found


def _at_bounds(best: Trial, space: GainSpace) -> list[str]:
    if not space.gains:
        return []  # their ranges are not known
    unit = space.to_unit([best.gains[name] for name in space.names])
    found = []
    for gain, share in zip(space.gains, np.atleast_1d(unit), strict=True):
        if not AT_BOUND < share < 1.0 - AT_BOUND:
            end = "lower" if share <= AT_BOUND else "upper"
            found.append(
                f"the best {gain.name} = {best.gains[gain.name]:.4g} lies at the {end} end of its "
                f"range [{gain.low:g}, {gain.high:g}]; better gains may lie beyond, widen [gains]"
            )
    return found
