"""Friction, load, delay and lag that are estimated with a twin's parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gmfbo import Recording, Study, Tuner
from gmfbo.recordings.recording import Trajectory
from gmfbo.recordings.store.study_folder import StudyStore
from gmfbo.retuning.corrected_methods import GMFBO_ESTIMATED, OnCorrectedTwin
from gmfbo.retuning.missing_physics import Completion
from gmfbo.retuning.refiner import PhysicsRefiner
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.twin.augmented_twin import AugmentedTwin
from gmfbo.sources.twin.twin import FmuTwin
from gmfbo.tuning.query.method import CorrectionOptions

METHOD = replace(GMFBO_ESTIMATED, correction=CorrectionOptions(survey=12, corrected=False))
STUDY = """
name = "servo"
seed = 2
[is1]
ask_tell = true
[is2]
twin = "{models}/servo_axis.toml"
[gains]
kp = {{ low = 20.0, high = 110.0, now = 60.0 }}
kd = {{ low = 0.4, high = 2.4, now = 1.2 }}
[reference]
step = 0.4
at = 0.1
horizon = 0.5
[budget]
initial_is1 = 2
initial_is2 = 10
is1_runs = 4
is3_per_run = 0
"""


class Axis:
    """The twin's servo under friction and a delay, with a little noise of its encoder."""

    def __init__(self, physics: Mapping[str, float]) -> None:
        twin = FmuTwin(models_folder() / "servo_axis.toml", isolated=False)
        self._axis = AugmentedTwin(twin, substeps=5, isolated=False)
        self._physics = physics
        self._rng = np.random.default_rng(0)

    def __call__(self, gains: Mapping[str, float], reference: Recording) -> Recording:
        asked = replace(reference, parameters=dict(gains))
        run = self._axis.run(self._axis.plan(asked, {}), {}, self._physics)
        noise = 3e-5 * self._rng.standard_normal(asked.time.size)
        return Trajectory(
            time=asked.time,
            signals={**run.held, "position": run.states["position"] + noise},
            parameters=dict(gains),
        )


def events_of(study: Study) -> list[Mapping[str, object]]:
    with StudyStore.open(study.location) as store:
        return [event for event in store.events() if event["event"] == "twin_version"]


def tuned(folder: Path, physics: Mapping[str, float], method: OnCorrectedTwin = METHOD) -> Study:
    """The study, opened anew for each run."""
    folder.mkdir()
    text = STUDY.format(models=models_folder().as_posix())
    (folder / "servo.toml").write_text(text, encoding="utf-8")
    study, axis = Study.read(folder / "servo.toml"), Axis(physics)
    for _ in range(5):
        with Tuner(study, method=method) as tuner:
            request = tuner.ask()
            if request is None:
                return study
            tuner.tell(request, axis(request.gains, tuner.experiment.reference))
    raise AssertionError("the study did not end")


def test_friction_and_delay_of_the_axis_are_estimated_and_kept(tmp_path: Path) -> None:
    level, delay = 0.3, 2e-3
    physics = {"coulomb_friction.level": level, "coulomb_friction.deflection": 1e-4}
    study = tuned(tmp_path / "missed", {**physics, "transport_delay.delay": delay})
    last = events_of(study)[-1]
    found = dict(last["parameters"])  # type: ignore[call-overload]
    assert found["physics.coulomb_friction.level"] == pytest.approx(level, rel=0.15)
    late = found["physics.transport_delay.delay"] + found["physics.actuator_lag.time"]
    # A short lag and a delay of the same length are one in a step response.
    assert late == pytest.approx(delay, abs=3e-4)
    assert last["named"] == []  # it is estimated, and nothing is claimed


def test_negative_control_nothing_is_added_to_a_twin_that_explains_the_axis(
    tmp_path: Path,
) -> None:
    study = tuned(tmp_path / "right", {})
    versions = events_of(study)
    assert versions
    assert all(version["augmented"] is None for version in versions)


@pytest.mark.parametrize(("friction", "expected"), [(0.3, [2, 3]), (0.0, [])])
def test_a_diagnosis_is_asked_at_two_and_three_runs_that_are_not_explained(
    tmp_path: Path, friction: float, expected: list[int]
) -> None:
    asked = []

    def spy(
        twin: FmuTwin,
        tables: Mapping[str, float],
        recordings: Sequence[Recording],
        folder: Path,
        *,
        seed: int,
    ) -> Completion | None:
        asked.append(len(recordings))
        return None

    method = replace(METHOD, refine=lambda t, f: PhysicsRefiner(t, f, spy, asks_again=True))
    physics = {"coulomb_friction.level": friction, "coulomb_friction.deflection": 1e-4}
    tuned(tmp_path / "asked", physics if friction else {}, method)
    assert asked == expected
