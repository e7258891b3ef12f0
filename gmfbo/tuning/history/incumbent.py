"""Choose the best run: settled runs come first, then those that meet all limits."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from gmfbo.objective.limits import Limits
from gmfbo.recordings.store.trial import Trial
from gmfbo.space import same_gain


def best_run(trials: Iterable[Trial], limits: Limits, since: int = 0) -> Trial | None:
    """Pick the best real run.

    Runs that settled come before those that did not, of which the one nearest to settling is the
    least bad. Among settled ones feasible runs come first (Deb 2000, "An efficient constraint
    handling method for genetic algorithms"). Among them the least cost counts, among the others
    the least excess over the limits.

    Parameters
    ----------
    trials : iterable of Trial
        Runs of any source.
    limits : Limits
        On metrics.
    since : int
        Trial number of the last real run before the plant changed; a later run is preferred.

    Returns
    -------
    Trial or None
        None while no real run succeeded.
    """
    finished = [trial for trial in trials if trial.source == "IS1" and trial.status == "ok"]
    finished = [trial for trial in finished if trial.number > since] or finished
    return min(
        finished,
        key=lambda trial: (
            max(trial.late_error or 0.0, 1.0),
            limits.excess(trial.metrics),
            trial.objective,
        ),
        default=None,
    )


def runs_at(gains: Mapping[str, float], trials: Iterable[Trial]) -> list[Trial]:
    """Runs at some gains, in order.

    Parameters
    ----------
    gains : mapping of str to float
        All gains by name [unit of the FMU parameter].
    trials : iterable of Trial
        Runs to choose from.
    """
    return [
        trial
        for trial in trials
        if all(same_gain(trial.gains[name], value) for name, value in gains.items())
    ]


def none_settled(runs: int | str) -> str:
    """Sentence that no real run settled, without its first capital and its full stop.

    Parameters
    ----------
    runs : int or str
        Number of real runs, or how a page writes it.
    """
    return f"no real run settled (of {runs}), so no gains are recommended"


def has_settled(trial: Trial) -> bool:
    """Whether a run ended well and settled, or is of a study that does not ask for it."""
    return trial.status == "ok" and (trial.late_error or 0.0) <= 1.0
