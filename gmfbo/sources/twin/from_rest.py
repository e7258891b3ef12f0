"""Runs that begin at rest: the first row of the inputs is held until the twin has settled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from gmfbo.sources.twin.run_plan import Experiment
from gmfbo.sources.twin.settling import probe_lengths, settled_after
from gmfbo.sources.worker.runner import Result, Runner


def settles_after(runner: Runner, experiment: Experiment) -> int:
    """Communication steps under the first row until the outputs are at rest; 0 where never.

    Parameters
    ----------
    runner : Runner
        Of the twin.
    experiment : Experiment
        Whose first row is held.
    """
    first, *longer = probe_lengths(experiment.step)
    probe = runner.run(experiment.probe_at_start(first))[0]
    if probe.outcome.status != "ok" or settled_after(probe.y, experiment.step) == 0:
        return 0
    return _held(runner, experiment, longer)


def run_from_rest(runner: Runner, experiment: Experiment) -> tuple[int, Result]:
    """Hold the first reference until the twin settles, then run.

    Parameters
    ----------
    runner : Runner
        Of the twin.
    experiment : Experiment
        The run.

    Returns
    -------
    tuple of int and Result
        Communication steps held, and the run.
    """
    first, *longer = probe_lengths(experiment.step)
    # Most runs begin at rest, so the run is ordered together with the first probe.
    probe, *run = runner.run(experiment.probe_at_start(first), experiment.order(0))
    if probe.outcome.status == "timeout":
        return 0, Result(replace(probe.outcome, rows=0), probe.y)  # do not wait for it twice
    if not run:
        return 0, runner.run(experiment.order(0))[0]
    if settled_after(probe.y, experiment.step) == 0:
        return 0, run[0]
    held = _held(runner, experiment, longer)
    return (held, runner.run(experiment.order(held))[0]) if held else (0, run[0])


def _held(runner: Runner, experiment: Experiment, lengths: Sequence[int]) -> int:
    """Steps after which the twin rests in the first probe that is long enough; 0 where in none."""
    for steps in lengths:
        probe = runner.run(experiment.probe_before_start(steps))[0]
        held = settled_after(probe.y, experiment.step) if probe.outcome.status == "ok" else 0
        if held is not None:
            return held
    return 0
