"""Grid of a plant: metrics over the whole box, simulated once and kept."""

from __future__ import annotations

import hashlib
import io
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from gmfbo.errors import StudyFileError
from gmfbo.files.durable import write_whole
from gmfbo.objective.margins import MARGINS
from gmfbo.sources.plants.source import Source
from gmfbo.studies.given_truth import GivenTruth
from gmfbo.tuning.experiment.experiment_series import ExperimentSeries
from gmfbo.tuning.study.playing import play
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.study.study_sources import StudySources
from gmfbo.tuning.study.study_terms import experiment_of, own_metrics
from gmfbo.tuning.study_file.gain_choice import GainChoice
from gmfbo.tuning.study_file.safety_section import SafetySection


@dataclass(frozen=True, eq=False)
class PlantGrid:
    """Metrics of one source over the box; m points, d gains.

    Attributes
    ----------
    names : tuple of str
        Tuned gains, in order.
    points : ndarray, shape (m, d)
        [unit of each gain]
    metrics : dict of str to ndarray, shape (m,)
        Each metric [% or s]; the worst case where a run failed.
    """

    names: tuple[str, ...]
    points: NDArray[np.float64]
    metrics: dict[str, NDArray[np.float64]]


def grid_points(gains: int, side: int) -> NDArray[np.float64]:
    """Cover the unit cube: a regular grid in one and two gains, a Sobol set in more.

    Parameters
    ----------
    gains : int
        d.
    side : int
        Points along a side in two gains; at least side^2 points for every d.

    Returns
    -------
    ndarray, shape (m, d)
        The last gain changes fastest.
    """
    if gains == 1:
        return np.linspace(0.0, 1.0, side * side)[:, None]
    if gains == 2:
        axis = np.linspace(0.0, 1.0, side)
        return np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2)
    power = int(np.ceil(2.0 * np.log2(side)))
    sobol = qmc.Sobol(gains, scramble=False)
    return np.asarray(sobol.random_base2(power), dtype=np.float64)


@dataclass(frozen=True, eq=False)
class TrueSources:
    """The sources of a study, opened to be run over the whole box.

    Attributes
    ----------
    sources : StudySources
        Opened for the study's seed; the caller closes them.
    gains : GainChoice
        Tuned and held gains.
    experiment : ExperimentSeries
        Experiment of every source.
    safety : SafetySection
        Safety envelope of the plant.
    given : GivenTruth or None
        Truth of a plant that is not run over the box.
    """

    sources: StudySources
    gains: GainChoice
    experiment: ExperimentSeries
    safety: SafetySection
    given: GivenTruth | None = None

    @classmethod
    def open(cls, study: Study) -> TrueSources:
        """Open the sources of a study whose plant can be simulated, or whose truth is given.

        Raises
        ------
        StudyFileError
            The plant cannot be run over the whole box, and no table tells its truth.
        """
        file = study.file
        if file.is1.twin is None and file.compare.truth is None:
            raise StudyFileError(
                f"{file.name}: [is1]: expected twin = FILE, the FMU that plays the plant, or "
                "[compare] truth = FILE, its noise-free metrics over the box; methods are compared "
                "against its true optimum"
            )
        if file.is1.twin is None and (file.is1.ask_tell or file.is1.recorded is not None):
            raise StudyFileError(
                f"{file.name}: [is1]: expected twin, command or function, which run by themselves; "
                "a comparison makes all real runs of all methods anew"
            )
        sources = StudySources.open(file, study.origin)
        try:
            gains = GainChoice.combine(sources.gains, file.gains, sources.parameters)
            experiment = experiment_of(study, sources, own_metrics(study))
            given = None if file.compare.truth is None else _given(study, gains)
        except BaseException:
            sources.close()
            raise
        return cls(sources, gains, experiment, file.safety, given)

    @property
    def plants(self) -> tuple[Source, ...]:
        """Plants that are run over the box: it, and the changed one; none where truth is given."""
        if self.given is not None:
            return ()
        both = (self.sources.is1, self.sources.changed_is1)
        return tuple(plant for plant in both if plant is not None)

    def noise_free(
        self, points: NDArray[np.float64], changed_after: int | None = None
    ) -> dict[str, NDArray[np.float64]]:
        """Metrics of the plant without noise, shape (n,).

        Parameters
        ----------
        points : ndarray, shape (n, d)
            Gains of real runs, in order [unit of each].
        changed_after : int or None
            Real runs before the plant changes.
        """
        if self.given is not None:
            return self.given.at(self.gains.space.to_unit(points))
        before = len(points) if changed_after is None else changed_after
        rows = [
            self._metrics(self.plants[0 if number < before else -1], point)
            for number, point in enumerate(points)
        ]
        return {name: np.array([row[name] for row in rows]) for name in rows[0]}

    def grid(self, source: Source, side: int, folder: Path) -> PlantGrid:
        """Run a source over the whole box, or read the grid of an earlier run.

        Parameters
        ----------
        source : Source
            One of the study's.
        side : int
            Points along a side.
        folder : Path
            Folder of the grids, one text each.
        """
        space = self.gains.space
        points = space.from_unit(grid_points(len(space), side))
        kept = folder / self.file_name(source, side)
        if not kept.exists():
            rows = [self._metrics(source, point) for point in points]
            folder.mkdir(parents=True, exist_ok=True)
            text = io.StringIO()
            table = np.array([list(row.values()) for row in rows])
            np.savetxt(
                text, table, fmt="%.12g", delimiter=",", header=",".join(rows[0]), comments=""
            )
            write_whole(kept, text.getvalue().encode())
        names = kept.read_text(encoding="utf-8").partition("\n")[0].split(",")
        columns = np.loadtxt(kept, delimiter=",", skiprows=1, ndmin=2).T
        return PlantGrid(space.names, points, dict(zip(names, columns, strict=True)))

    def _metrics(self, source: Source, point: NDArray[np.float64]) -> dict[str, float]:
        envelope = self.safety.envelope if source in self.plants else None
        run = play(source, self.gains.values(point), self.experiment, envelope)
        return self.experiment.metrics(run)

    def file_name(self, source: Source, side: int) -> str:
        """Name of a grid's file; two seeds share it where the plant has no seed."""
        own = self.experiment.own
        decisive: list[Any] = [source.content_hash, side, self.experiment.signal, repr(self.gains)]
        decisive += [
            own.content_hash if own else "",
            repr(self.experiment.terms),
            source in self.plants and self.safety.model_dump_json(),
        ]
        for part, share in zip(self.experiment.parts, self.experiment.shares, strict=True):
            columns = [part.reference.time, *part.reference.signals.values()]
            decisive += [share, part.horizon, list(part.reference.signals)]
            decisive += [column.tobytes().hex() for column in columns]
        return f"{hashlib.sha256(json.dumps(decisive).encode()).hexdigest()[:16]}.csv"


def _given(study: Study, gains: GainChoice) -> GivenTruth:
    file = study.file
    if file.is1.change is not None:
        raise StudyFileError(
            f"{file.name}: expected no [is1] change beside [compare] truth, a table of one plant"
        )
    counted = frozenset({*file.objective.weights, *file.constraints} - {*MARGINS})
    return GivenTruth.read(study.origin / str(file.compare.truth), gains.space, counted)
