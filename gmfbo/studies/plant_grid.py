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
from gmfbo.sources.plants.source import Source
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
    """

    sources: StudySources
    gains: GainChoice
    experiment: ExperimentSeries
    safety: SafetySection

    @classmethod
    def open(cls, study: Study) -> TrueSources:
        """Open the sources of a study whose plant can be simulated.

        Raises
        ------
        StudyFileError
            The plant cannot be run over the whole box.
        """
        file = study.file
        if file.is1.twin is None:
            raise StudyFileError(
                f"{file.name}: [is1]: expected twin = FILE, the FMU that plays the plant; methods "
                "are compared against its true optimum, for which it runs all over the box"
            )
        sources = StudySources.open(file, study.origin)
        try:
            gains = GainChoice.combine(sources.gains, file.gains, sources.parameters)
            experiment = experiment_of(study, sources, own_metrics(study))
        except BaseException:
            sources.close()
            raise
        return cls(sources, gains, experiment, file.safety)

    @property
    def plants(self) -> tuple[Source, ...]:
        """The plant, and the changed plant where it changes."""
        both = (self.sources.is1, self.sources.changed_is1)
        return tuple(plant for plant in both if plant is not None)

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
