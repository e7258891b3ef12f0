"""Metrics with their units, and what each counts in the objective, as lines of text."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

from gmfbo.objective.margins import MARGINS
from gmfbo.objective.metric_units import metric_unit
from gmfbo.objective.metrics import METRICS
from gmfbo.plain_words import words

if TYPE_CHECKING:
    from gmfbo.objective.cost import Objective


def metric_text(name: str, value: float, units: Mapping[str, str], never: float = math.inf) -> str:
    """A metric with its unit, or `never` for a time that was not reached.

    Parameters
    ----------
    name : str
        As it is stored.
    value : float
        [unit of the metric]
    units : mapping of str to str
        As the study has logged them.
    never : float
        [s] Length after the step that is scored: a time of a step metric that is as long was not
        reached.
    """
    unit = metric_unit(name, units)
    # A mean over references is never the horizon unless each of them is.
    if unit == "s" and name.partition("[")[0] in METRICS and value >= never * (1.0 - 1e-9):
        return f"never (within {never:g} s)"
    if math.isnan(value):
        return "not measured"
    digits = {"%": ".2f", "s": ".4f"}.get(unit, ".5g")
    of_twin = " (from the twin)" if name in MARGINS else ""
    return f"{value:{digits}} {unit}".rstrip() + of_twin


def objective_table(
    objective: Objective, metrics: Mapping[str, float], units: Mapping[str, str], samples: str
) -> list[str]:
    """What each weighted metric counts, and what it adds to the objective of a run.

    Parameters
    ----------
    objective : Objective
        With weights and constants.
    metrics : mapping of str to float
        Of the run.
    units : mapping of str to str
        As the study has logged them.
    samples : str
        Where mean and spread come from, such as `10 twin runs`.

    Returns
    -------
    list of str
        A heading and a line for each weighted metric; the last column sums to the objective.
    """
    weighted = {n: w for n, w in objective.weights.items() if w > 0.0 and n in metrics}
    total = sum(objective.weights.values())
    lines = [f"what counts        mean and spread of {samples}; the last column adds up"]
    for name, weight in weighted.items():
        alone = objective.contribution(name, metrics[name])
        mean = metric_text(name, objective.mean[name], units)
        spread = metric_text(name, objective.std[name], units)
        value = metric_text(name, metrics[name], units, objective.worst.get(name, math.inf))
        lines.append(
            f"  {words(name):<16} {value} counts {weight:.2f} of "
            f"{total:.2f}, mean {mean}, spread {spread}: {alone:+.4f}"
        )
    return lines
