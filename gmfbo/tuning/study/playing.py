"""Play a query: a source follows each reference, and the responses become one run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from gmfbo.errors import RecordingError
from gmfbo.objective.envelope import Envelope
from gmfbo.recordings.recording import Recording, Trajectory
from gmfbo.sources.plants.run_guard import LATENCY
from gmfbo.sources.plants.source import Source
from gmfbo.tuning.experiment.experiment_series import ExperimentSeries
from gmfbo.tuning.experiment.joined_runs import ended_by
from gmfbo.tuning.study.study_sources import run_source


def play(
    source: Source,
    gains: Mapping[str, float],
    experiment: ExperimentSeries,
    envelope: Envelope | None = None,
) -> Recording:
    """Run all references at some gains, until one fails or leaves the envelope.

    Parameters
    ----------
    source : Source
        Source of the run.
    gains : mapping of str to float
        Gains of the query.
    experiment : ExperimentSeries
        References that are played.
    envelope : Envelope, optional
        Safety envelope of the real axis; a twin has none.

    Returns
    -------
    Recording
        The joined run; of status `unsafe` where it left the envelope.

    Raises
    ------
    InputError
        The request is impossible for the source, so that repeating it cannot help.
    """
    runs: list[Recording] = []
    for reference in experiment.references:
        run = run_source(source, gains, reference)
        guarded = bool(envelope) or LATENCY in run.parameters
        runs.append(_judged(run, envelope) if envelope is not None and guarded else run)
        if isinstance(runs[-1], Trajectory) and runs[-1].status != "ok":
            break
    return experiment.join(runs)


def _judged(run: Recording, envelope: Envelope) -> Recording:
    """A run marked unsafe where it leaves the envelope, or where this cannot be judged."""
    try:
        judged = envelope.judge(run)
    except RecordingError as error:
        return ended_by(run, "unsafe", f"safety cannot be judged: {error}")
    latency = run.parameters.get(LATENCY)
    if latency is None:
        return judged
    told = f"the plant's own abort came {1e3 * latency:.3g} ms after its sample"
    if isinstance(judged, Trajectory) and judged.status == "unsafe":
        return replace(judged, message=f"{judged.message}; {told}")
    return ended_by(run, "unsafe", told)
