"""Every kind of plant over one axis, each with its study and its way to run it.

`python -m tests.tuning.plants.plant_kinds KIND FOLDER` runs or goes on with such a study and
prints the number of each trial, until it ends or is ended.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from gmfbo.errors import SimulationError
from gmfbo.recordings.recording import Recording
from gmfbo.recordings.reference import step_reference
from gmfbo.recordings.writing.writer import write_recording
from gmfbo.sources.plants.failed_run import failed_run
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.tuner import Tuner
from tests.tuning.analytic_axis import STUDY, AnalyticAxis
from tests.tuning.plants.bench import TRIPS_ABOVE

BENCH = Path(__file__).with_name("bench.py")
REFERENCE = step_reference(1.0, at=0.05, horizon=0.5, sample_time=2e-3)
Tell = Callable[[int], None]


def tripping_axis(gains: Mapping[str, float], reference: Recording) -> Recording:
    """The axis in closed form; it trips where `bench.py` does."""
    if gains["ctl.Kp"] > TRIPS_ABOVE:
        raise SimulationError("the drive tripped")
    return AnalyticAxis().run(gains, reference)


@dataclass(frozen=True)
class PlantKind:
    """One kind of plant.

    Attributes
    ----------
    section : str
        Part `[is1]` of the study file.
    prepare : callable
        Puts what the plant needs into the study's folder.
    finish : callable
        Runs the study from where it is to its end, and reports each real run.
    """

    section: str
    prepare: Callable[[Path], None]
    finish: Callable[[Study, Tell], None]

    def study(self, folder: Path, *, budget: str = "iterations = 6", seed: int = 1) -> Study:
        """Write a study of this kind, or read the one that is there."""
        path = folder / "axis.toml"
        if not path.exists():
            folder.mkdir(parents=True)
            text = STUDY.format(method="random", seed=seed, budget=budget)
            text = text.replace("[budget]", "[objective]\nas_published = true\n[budget]")
            path.write_text(text.replace("ask_tell = true", self.section), encoding="utf-8")
            self.prepare(folder)
        return Study.read(path)


def twin() -> AnalyticAxis:
    """The twin that is almost right."""
    return AnalyticAxis(inertia=0.2, friction=0.4)


def _run(study: Study, tell: Tell) -> None:
    with Tuner(study, is2=twin()) as tuner:
        tuner.run(lambda event: tell(event.trial))


def _call(study: Study, tell: Tell) -> None:
    with Tuner(study, is2=twin(), plant=tripping_axis) as tuner:
        tuner.run(lambda event: tell(event.trial))


def _ask_and_tell(study: Study, tell: Tell) -> None:
    """As a person does: each step in a tuner of its own, the recording as a file."""
    file = study.origin / "measured.csv"
    while True:
        with Tuner(study, is2=twin()) as tuner:
            request = tuner.ask()
        if request is None:
            return
        try:
            run, tripped = tripping_axis(request.gains, REFERENCE), False
        except SimulationError as error:
            run, tripped = failed_run(REFERENCE, str(error)), True
        write_recording(run, file)
        # A failed run has no rows that differ from those of another.
        with Tuner(study, is2=twin()) as tuner:
            told = tuner.tell(request.number, file, anyway=tripped)
        tell(told.number)


def _record_grid(folder: Path) -> None:
    """Recordings at 7 x 6 gains; those of runs that tripped say so."""
    (folder / "grid").mkdir()
    for stiffness in np.linspace(30.0, 200.0, 7):
        for damping in np.linspace(2.0, 10.0, 6):
            gains = {"ctl.Kp": float(stiffness), "ctl.Kd": float(damping)}
            try:
                run = tripping_axis(gains, REFERENCE)
            except SimulationError as error:
                run = replace(failed_run(REFERENCE, str(error)), parameters=gains)
            write_recording(run, folder / "grid" / f"kp{stiffness:.0f}_kd{damping:.1f}.csv")


def _nothing(folder: Path) -> None:
    """The plant needs no file."""


KINDS = {
    "command": PlantKind(f"command = ['{sys.executable}', '{BENCH}']", _nothing, _run),
    "ask_tell": PlantKind("ask_tell = true", _nothing, _ask_and_tell),
    "recorded": PlantKind('recorded = "grid/"', _record_grid, _run),
    "callable": PlantKind("ask_tell = true", _nothing, _call),
}


if __name__ == "__main__":
    kind = KINDS[sys.argv[1]]
    kind.finish(kind.study(Path(sys.argv[2])), lambda trial: print(trial, flush=True))
