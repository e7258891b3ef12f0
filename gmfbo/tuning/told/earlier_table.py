"""A table of gains and results of runs made before a study began, as real runs of it.

No trajectory comes with a row. So methods learn from its cost, and nothing that compares
trajectories learns from it: no correction of the twin, no estimate of its parameters, no watch for
a change of the plant. Nor does a row show that a run stayed inside a safety envelope.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import RecordingError, StudyFileError, did_you_mean
from gmfbo.objective.margins import MARGINS
from gmfbo.objective.metric_units import metric_unit
from gmfbo.objective.metric_words import MetricWords
from gmfbo.objective.tracking import COMMAND_METRICS, TRACKING_METRICS
from gmfbo.plain_words import words
from gmfbo.recordings.columns.columns import Column
from gmfbo.recordings.reader import read_columns
from gmfbo.recordings.recording import Recording
from gmfbo.recordings.store.trial import Trial
from gmfbo.tuning.experiment.experiment_series import ExperimentSeries
from gmfbo.tuning.history.history import History
from gmfbo.tuning.study_file.gain_choice import GainChoice
from gmfbo.tuning.study_file.study_sections import KNOWN_METRICS, StudyFile
from gmfbo.tuning.told.earlier_fit import why_not
from gmfbo.units import Unit, parse_unit

STUDIES = (".toml", ".h5", ".hdf5")
"""Endings of files that are a study, and no table."""

_TIMES = ("settling_time", "rise_time")
"""Times as long as the horizon in a run that did not settle."""


@dataclass(frozen=True)
class TableTerms:
    """What a study reads in a table.

    Attributes
    ----------
    gains : GainChoice
        Tuned and held gains of the study.
    counted : tuple of str
        Metrics with a weight or a limit, without margins, which the twin tells.
    known : tuple of str
        Metrics that are taken where the table has them.
    units : mapping of str to str
        Unit of each gain and metric in the study; empty where it is unknown.
    told : MetricWords
        Tells the times that were not reached.
    """

    gains: GainChoice
    counted: tuple[str, ...]
    known: tuple[str, ...]
    units: Mapping[str, str]
    told: MetricWords

    @classmethod
    def of(
        cls,
        file: StudyFile,
        gains: GainChoice,
        experiment: ExperimentSeries,
        units: Mapping[str, str],
    ) -> Self:
        """Terms of a study.

        Parameters
        ----------
        file : StudyFile
            With weights, limits, and units of the user's own metrics.
        gains : GainChoice
            Tuned and held gains.
        experiment : ExperimentSeries
            Names the metrics.
        units : mapping of str to str
            Of the gains.
        """
        weighed = [name for name, weight in file.objective.weights.items() if weight > 0.0]
        counted = tuple(n for n in dict.fromkeys([*weighed, *file.constraints]) if n not in MARGINS)
        known = tuple(dict.fromkeys([*experiment.metric_names, *counted, *file.own_metrics]))
        of_metrics = {name: metric_unit(name, file.objective.units) for name in known}
        told = MetricWords(of_metrics, experiment.worst)
        return cls(gains, counted, known, {**of_metrics, **units}, told)


@dataclass(frozen=True, eq=False)
class EarlierTable:
    """Gains and metrics of n runs.

    Attributes
    ----------
    name : str
        File name.
    terms : TableTerms
        What was read.
    stated : mapping of str to float
        Values of its `# NAME = VALUE` lines, which hold for all rows.
    columns : mapping of str to ndarray, shape (n,)
        Gains and metrics in the units of the study; NaN where a cell has no number.
    """

    name: str
    terms: TableTerms
    stated: Mapping[str, float]
    columns: Mapping[str, NDArray[np.float64]]

    @classmethod
    def read(cls, label: str, path: Path, terms: TableTerms) -> Self:
        """Read a table.

        Parameters
        ----------
        label : str
            The key of the study file, for messages.
        path : Path
            Text with a column a gain and a column a metric; others are ignored.
        terms : TableTerms
            What the study reads.

        Raises
        ------
        StudyFileError
            It cannot be read, lacks a column, or a unit cannot be converted.
        """
        wanted = (*terms.gains.space.names, *terms.gains.fixed, *terms.known)
        try:
            file = read_columns(path, wanted=wanted)
        except RecordingError as error:
            raise StudyFileError(f"{label}: {error}") from None
        found = {column.name: column for column in file.columns}
        for name in (*terms.gains.space.names, *terms.counted):
            if name not in found and not (name in file.scalars and name not in terms.known):
                raise StudyFileError(
                    f"{label}: no column '{name}'{did_you_mean(name, found)}; a table has a column "
                    "for each tuned gain and each metric with a weight or a limit, and recordings "
                    "belong into a folder"
                )
        columns = {n: _converted(label, found[n], terms.units[n]) for n in wanted if n in found}
        stated = {name: value for name, value in file.scalars.items() if name in wanted}
        return cls(path.name, terms, stated, columns)

    def chosen(self) -> tuple[list[int], dict[str, int]]:
        """Rows that the study takes over, from 1, and the number of others by reason."""
        taken: list[int] = []
        left: dict[str, int] = {}
        for row in range(1, len(next(iter(self.columns.values()))) + 1):
            if why := self._why_not(row):
                left[why] = left.get(why, 0) + 1
            else:
                taken.append(row)
        return taken, left

    def trial(self, row: int) -> Trial:
        """A row, from 1, as a real run of which gains and metrics alone are known."""
        known, gains = self._known(row), self.terms.gains
        values = {name: known[name] for name in (*gains.space.names, *gains.fixed)}
        metrics = {name: known[name] for name in self.terms.known if name in known}
        # A recording has a row at least; without signals it says nothing.
        empty = Recording(np.zeros(1), {}, name=f"{self.name}, row {row}", parameters=values)
        return Trial(0, "IS1", values, empty, float("nan"), metrics)

    def _known(self, row: int) -> dict[str, float]:
        """What a row says; cells without a number say nothing."""
        cells = {name: float(values[row - 1]) for name, values in self.columns.items()}
        return {**self.stated, **{n: value for n, value in cells.items() if np.isfinite(value)}}

    def _why_not(self, row: int) -> str:
        known, terms = self._known(row), self.terms
        if why := why_not({}, known, terms.gains):
            return why
        for name in terms.counted:
            if name not in known:
                return f"{words(name)} is missing"
        for name in _TIMES:
            if name in known and terms.told.is_never(name, known[name]):
                return f"{words(name)} is as long as the horizon: the run did not settle"
        return ""


def taken_row(row: Trial, history: History) -> Trial:
    """A row of a table as the next trial of a study, with its cost; it is not yet on disk.

    Parameters
    ----------
    row : Trial
        Of `EarlierTable.trial`.
    history : History
        With the initial runs of the twin, whose other metrics the row does not have.
    """
    unknown = dict.fromkeys(history.of("IS2")[0].metrics, float("nan"))
    metrics = {**unknown, **row.metrics, **history.margins.at(row.gains)}
    return history.priced(
        replace(
            row,
            number=history.next_number,
            seed=history.study.seed,
            metrics=metrics,
            late_error=0.0 if history.ranked else None,
        )
    )


def _converted(label: str, column: Column, wanted: str) -> NDArray[np.float64]:
    """Values of a column in a unit of the study, which may be unknown."""
    if not column.unit:
        return column.values
    unit, own = parse_unit(column.unit), parse_unit(wanted) if wanted else None
    if unit is None:
        raise StudyFileError(
            f"{label}: '{column.name}' is in '{column.unit}', which is no known unit; correct the "
            "header, or leave the unit out"
        )
    if own is None and (unit.is_si or column.name in (*TRACKING_METRICS, *COMMAND_METRICS)):
        return unit.to_si(column.values)  # signals are in SI, and so are metrics of them
    if own is None or own.dimension != unit.dimension:
        study = f"'{wanted}'" if wanted else "no unit"
        cure = (
            "state it by [objective] units"
            if not wanted and column.name not in KNOWN_METRICS
            else "correct the header, or leave the unit out"
        )
        raise StudyFileError(
            f"{label}: '{column.name}' is in '{column.unit}', and the study has {study} for it; "
            f"{cure}"
        )
    return _from_si(unit.to_si(column.values), own)


def _from_si(values: NDArray[np.float64], unit: Unit) -> NDArray[np.float64]:
    size = float(unit.to_si(np.ones(1))[0]) - unit.zero
    return (values - unit.zero) / size
