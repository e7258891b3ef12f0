"""What each metric counts in the objective, as lines of text."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from gmfbo.objective.metric_words import MetricWords
from gmfbo.plain_words import words

if TYPE_CHECKING:
    from gmfbo.objective.cost import Objective


def objective_table(
    objective: Objective, metrics: Mapping[str, float], told: MetricWords, samples: str
) -> list[str]:
    """What each weighted metric counts, and what it adds to the objective of a run.

    Parameters
    ----------
    objective : Objective
        With weights and constants.
    metrics : mapping of str to float
        Of the run.
    told : MetricWords
        Of the study.
    samples : str
        Where mean and spread come from, such as `10 twin runs`.

    Returns
    -------
    list of str
        A heading and a line for each weighted metric; the last column sums to the objective.
    """
    weighted = {n: w for n, w in objective.weights.items() if w > 0.0 and n in metrics}
    total = sum(objective.weights.values())
    number = MetricWords(told.units, {})  # a mean as long as the horizon is no single time
    lines = [f"what counts        mean and spread of {samples}; the last column adds up"]
    for name, weight in weighted.items():
        alone = objective.contribution(name, metrics[name])
        mean, spread = (number.text(name, of[name]) for of in (objective.mean, objective.std))
        value = told.text(name, metrics[name])
        lines.append(
            f"  {words(name):<16} {value} counts {weight:.2f} of "
            f"{total:.2f}, mean {mean}, spread {spread}: {alone:+.4f}"
        )
    return lines
