"""What a study came to, as text: the gains to take first, then what a reader must know of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gmfbo.cli.console import console, gains_text
from gmfbo.errors import SimulationError
from gmfbo.objective.metrics import METRICS

if TYPE_CHECKING:
    from gmfbo.recordings.store.trial import Trial
    from gmfbo.reports.study.review import StudyReview
    from gmfbo.tuning.query.request import TuningResult
    from gmfbo.tuning.study.study import Study


def print_result(study: Study | StudyReview, result: TuningResult) -> None:
    """Print the gains that a study recommends, the best run, and remarks on both.

    Parameters
    ----------
    study : Study or StudyReview
        The study.
    result : TuningResult
        Its result.
    """
    console.print(
        f"{study.file.name}: {study.file.method}, {result.is1_runs} real runs, "
        f"{result.queries} queries after the initial data, "
        f"cost {result.cost:.1f} (a twin run counts 0.1)"
    )
    if result.earlier:
        left = f", {result.left_out} at other gains left out" if result.left_out else ""
        runs = f"{result.earlier} real runs of {study.file.earlier}{left}"
        console.print(f"taken over         {runs}", markup=False)
    for drift in result.drifts:
        console.print(f"plant changed      {drift.message}")
    for number, reason in enumerate(result.twin_versions, start=1):
        console.print(f"twin version {number:<6}{reason}", markup=False)
    _print_gains(study, result)
    for remark in result.remarks:
        console.print(f"note               {remark}", markup=False)
    console.print(f"study folder       {study.location}")


def refuse_without_success(result: TuningResult) -> None:
    """Raise where no real run succeeded, so that a script notices.

    Parameters
    ----------
    result : TuningResult
        Result of a study whose budget is used up.

    Raises
    ------
    SimulationError
        All real runs failed or left the safety envelope.
    """
    if result.best is None and result.is1_runs:
        reason = f" (the last: {result.last_failure})" if result.last_failure else ""
        raise SimulationError(
            f"no real run succeeded: all {result.is1_runs} failed or left the envelope{reason}; "
            "play one run by hand, name the gains in force in [gains] (now = ...), or check the "
            "limits of [safety]"
        )


def metric_text(name: str, value: float, horizon: float = float("inf")) -> str:
    """A metric with its unit, or `never` for a time that was not reached.

    Parameters
    ----------
    name : str
        Of the metric.
    value : float
        Its value; a user's own has no unit.
    horizon : float
        [s] Length after the step that is scored.
    """
    kind = name.partition("[")[0]
    if kind not in METRICS:
        return f"{value:.6g}"
    if kind == "overshoot":
        return f"{value:.2f} %"
    # A mean over references is never the horizon unless each of them is.
    never = value >= horizon * (1.0 - 1e-9)
    return f"never (within {horizon:g} s)" if never else f"{value:.4f} s"


def metric_lines(study: Study | StudyReview, trial: Trial) -> list[str]:
    """Metrics of a run, one a line, each with its name.

    Parameters
    ----------
    study : Study or StudyReview
        Knows how long a run is scored.
    trial : Trial
        A run that ended well.
    """
    horizons = [reference.horizon for reference in study.file.references]
    shares = [reference.weight for reference in study.file.references]
    mean = sum(h * w for h, w in zip(horizons, shares, strict=True)) / sum(shares)
    lines = []
    for name, value in trial.metrics.items():
        _, bracket, number = name.partition("[")
        horizon = horizons[int(number[:-1]) - 1] if bracket else mean
        lines.append(f"{name.replace('_', ' '):<15} {metric_text(name, value, horizon)}")
    return lines


def _print_gains(study: Study | StudyReview, result: TuningResult) -> None:
    if result.best is None:
        console.print("no real run succeeded, so there are no gains to take")
        return
    if not result.settled:
        console.print(
            f"no real run settled (of {result.is1_runs}), so no gains are recommended; "
            "below is the least bad run"
        )
    if result.recommendation is not None:
        advised = result.recommendation
        console.print(f"recommended        {gains_text(advised.gains)}")
        console.print(f"                   expected {advised.mean:.4f} +- {advised.std:.4f}")
    label = "best observed" if result.settled else "least bad"
    console.print(f"{label:<19}{gains_text(result.best.gains)}")
    console.print(f"                   objective {result.best.objective:.4f}")
    for line in metric_lines(study, result.best):
        console.print(f"                   {line}", markup=False)
