"""Metrics in words: each with its unit, and `never` for a time that was not reached."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Self

from gmfbo.objective.margins import MARGINS
from gmfbo.objective.metric_units import metric_unit
from gmfbo.objective.metrics import METRICS

OF_TWIN = "from the twin"
"""Mark of a margin: the twin alone is excited to measure it."""

_DIGITS = {"%": ".2f", "s": ".4f"}


@dataclass(frozen=True)
class MetricWords:
    """Words for the metrics of a study.

    Attributes
    ----------
    units : mapping of str to str
        As the study has logged them.
    longest : mapping of str to float
        [s] Length after the step that is scored, by metric: a time of a step metric that is as
        long was not reached. A metric that is not there is always a number.
    """

    units: Mapping[str, str]
    longest: Mapping[str, float]

    @classmethod
    def of(
        cls, units: Mapping[str, str], worst: Mapping[str, float], horizons: Sequence[float]
    ) -> Self:
        """Words of a study with one reference or several.

        Parameters
        ----------
        units : mapping of str to str
            As the study has logged them.
        worst : mapping of str to float
            Metrics of a failed run; of several references their mean.
        horizons : sequence of float
            [s] Scored length of each reference.
        """
        # A mean over references is never the horizon unless each of them is.
        each = {
            f"{name}[{place}]": horizon
            for place, horizon in enumerate(horizons, start=1)
            for name in METRICS
        }
        return cls(units, {**worst, **each})

    def is_never(self, name: str, value: float) -> bool:
        """Whether a metric is a time that was not reached, for which the horizon stands.

        Parameters
        ----------
        name : str
            As it is stored.
        value : float
            [unit of the metric]
        """
        timed = name.partition("[")[0] in METRICS and metric_unit(name, self.units) == "s"
        return timed and name in self.longest and value >= self.longest[name] * (1.0 - 1e-9)

    def text(self, name: str, value: float) -> str:
        """A metric with its unit, or `never`; a margin is marked as the twin's.

        Parameters
        ----------
        name : str
            As it is stored.
        value : float
            [unit of the metric]
        """
        if self.is_never(name, value):
            return never_words(f"{self.longest[name]:g}")
        if math.isnan(value):
            return "not measured"
        unit = metric_unit(name, self.units)
        of_twin = f" ({OF_TWIN})" if name in MARGINS else ""
        return f"{value:{_DIGITS.get(unit, '.5g')}} {unit}".rstrip() + of_twin


def never_words(longest: str) -> str:
    """What a time is called that was not reached.

    Parameters
    ----------
    longest : str
        [s] Length that is scored, as text or HTML.
    """
    return f"never (within {longest} s)"
