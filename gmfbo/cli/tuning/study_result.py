"""What a study came to, as text: the gains to take first, then what a reader must know of them."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from gmfbo.cli.console import console, gains_text, whole_words
from gmfbo.cli.tuning.objective_text import objective_table
from gmfbo.errors import SimulationError, TwinFileError
from gmfbo.objective.margins import MARGINS
from gmfbo.objective.metrics import METRICS
from gmfbo.objective.tracking import COMMAND_METRICS, TRACKING_METRICS
from gmfbo.plain_words import words
from gmfbo.tuning.history.incumbent import none_settled

if TYPE_CHECKING:
    from gmfbo.recordings.store.trial import Trial
    from gmfbo.reports.study.review import StudyReview
    from gmfbo.tuning.query.request import TuningResult
    from gmfbo.tuning.study.study import Study
    from gmfbo.tuning.study_file.study_sections import StudyFile


def print_result(study: Study | StudyReview, result: TuningResult) -> None:
    """Print the gains that a study recommends, the best run, remarks, and what counts.

    Where there is nothing to recommend, that comes first.

    Parameters
    ----------
    study : Study or StudyReview
        The study.
    result : TuningResult
        Its result.
    """
    if result.best is None:
        console.print("no real run succeeded, so there are no gains to take")
    elif not result.settled:
        console.print(f"{none_settled(result.is1_runs)}; below is the least bad run")
    console.print(
        f"{study.file.name}: {study.file.method}, {result.is1_runs} real runs, "
        f"{result.is2_runs + result.is3_runs:,} simulated"
    )
    if result.earlier:
        runs = f"{result.earlier} real runs of {study.file.earlier}"
        _print_entry("taken over", runs)
    for why in result.why_left_out:
        _print_entry("not taken over", why)
    for drift in result.drifts:
        _print_entry("plant changed", drift.message)
    for number, reason in enumerate(result.twin_versions, start=1):
        _print_entry(f"twin version {number}", reason)
    for line in result.learned:
        _print_entry("", line)
    _print_gains(study, result)
    for remark in result.remarks:
        _print_entry("note", remark)
    if result.best is not None:
        _print_counts(study, result.best)
    console.print(f"study folder       {study.location}")


def print_next_step(study: Study, result: TuningResult) -> None:
    """Print the command that asks a study's real runs what the twin lacks.

    Nothing is printed where a diagnosis has no port to try physics at, or fewer runs than two.

    Parameters
    ----------
    study : Study
        That has ended.
    result : TuningResult
        Its result.
    """
    twin = study.origin / study.file.is2.twin
    if result.is1_runs < 2 or result.best is None or not _has_ports(twin):
        return
    out = study.location.with_suffix(".found")
    command = shlex.join(["gmfbo", "diagnose", str(twin), str(study.location), "--out", str(out)])
    _print_entry("then", command)


def _has_ports(twin: Path) -> bool:
    from gmfbo.sources.twin_file.twin_file import TwinFile

    try:
        return bool(TwinFile.read(twin).ports)
    except TwinFileError:
        return False  # the twin is a source of the user's own


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


def metric_lines(study: Study | StudyReview, trial: Trial) -> list[str]:
    """Metrics of a run, one a line, each with its name; a time that was not reached is `never`.

    Those of tracking, command and loop that have neither weight nor limit stay in the report.

    Parameters
    ----------
    study : Study or StudyReview
        Knows weights, limits, units, and how long a run is scored.
    trial : Trial
        A run that ended well.
    """
    told = study.metric_words
    return [
        f"{words(name):<15} {told.text(name, trial.metrics[name])}"
        for name in shown_metrics(study.file, trial.metrics)
    ]


def shown_metrics(file: StudyFile, metrics: Mapping[str, float]) -> list[str]:
    """Metrics worth a line: all without a weight or limit of theirs stay in the report.

    Parameters
    ----------
    file : StudyFile
        With weights and limits.
    metrics : mapping of str to float
        Of a run.
    """
    wanted = {*METRICS, *file.objective.weights, *file.constraints, *file.own_metrics}
    ours = {*TRACKING_METRICS, *COMMAND_METRICS, *MARGINS}
    return [n for n in metrics if (base := n.partition("[")[0]) in wanted or base not in ours]


def _print_entry(name: str, text: str) -> None:
    for line in whole_words(text, f"{name:<19}"):
        console.print(line, markup=False)


def _print_gains(study: Study | StudyReview, result: TuningResult) -> None:
    if result.best is None:
        return
    if result.recommendation is not None:
        advised = result.recommendation
        console.print(f"recommended        {gains_text(advised.gains)}")
        for unmet in result.unmet:
            _print_entry("", unmet)
        console.print(f"                   expected {advised.mean:.4f} +- {advised.std:.4f}")
    label = "best observed" if result.settled else "least bad"
    console.print(f"{label:<19}{gains_text(result.best.gains)}")
    console.print(f"                   objective {result.best.objective:.4f}")
    for line in metric_lines(study, result.best):
        console.print(f"                   {line}", markup=False)


def _print_counts(study: Study | StudyReview, best: Trial) -> None:
    """Print what each weighted metric of a run counts."""
    objective = study.objective
    if objective is None:
        return
    normalise = study.file.objective.normalise
    samples = "the study file" if normalise.points is None else f"{normalise.points} twin runs"
    for line in objective_table(objective, best.metrics, study.metric_words, samples):
        console.print(line, markup=False)
