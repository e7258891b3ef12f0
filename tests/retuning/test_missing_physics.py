"""The diagnosis' answer as a twin that tuning can use."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from gmfbo import FmuTwin, Recording, step_reference
from gmfbo.recordings.recording import Trajectory
from gmfbo.retuning.missing_physics import Completion, complete
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.twin.augmented_twin import AugmentedTwin

pytestmark = pytest.mark.slow

AXIS = models_folder() / "servo_axis.toml"
GAINS = ({"kp": 60.0, "kd": 1.2}, {"kp": 110.0, "kd": 2.0}, {"kp": 85.0, "kd": 1.5})


def played(physics: Mapping[str, float], back: float = 0.7) -> list[Recording]:
    """Steps there, and back at a time [s], at three gains, of an axis with some physics."""
    there = step_reference(0.4, at=0.1, horizon=0.6)
    time = np.linspace(0.0, 1.399, 1400)
    wave = np.interp(time, there.time, there.signals["reference"]) * (time < back)
    rng = np.random.default_rng(5)
    runs = []
    with AugmentedTwin(FmuTwin(AXIS), substeps=10) as axis:
        names = list(axis.twin.file.gains)
        for gains in GAINS:
            values = dict(zip(names, gains.values(), strict=True))
            asked = Recording(time=time, signals={"reference": wave}, parameters=values)
            noise = 3e-5 * rng.standard_normal(time.size)
            run = axis.run(
                axis.plan(asked, {}),
                {},
                physics,
                excitation={"sensor": noise},
            )
            logged = {"reference": wave, **run.held, "position": run.states["position"] + noise}
            runs.append(Recording(time=time, signals=logged, parameters=values, written_by="test"))
    return runs


def position_error(run: Trajectory, recording: Recording) -> float:
    """RMS [rad]."""
    return float(np.std(run.signal("position") - recording.signal("position")))


@pytest.fixture(scope="module")
def completed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Completion, list[Recording]]:
    recordings = played({"coulomb_friction.level": 0.2})
    with FmuTwin(AXIS) as twin:
        found = complete(
            twin, {}, recordings[:2], tmp_path_factory.mktemp("made") / "00001", seed=0
        )
    assert found is not None
    return found, recordings


def test_the_completed_twin_predicts_a_run_that_nobody_saw(
    completed: tuple[Completion, list[Recording]],
) -> None:
    found, recordings = completed
    values = {scalar.name: scalar.nominal for scalar in found.scalars} | dict(found.parameters)
    with FmuTwin(AXIS) as given:
        before = position_error(given.run({}, recordings[2]), recordings[2])
    after = position_error(found.twin.run({}, recordings[2], parameters=values), recordings[2])
    assert after < 0.2 * before


def test_no_reference_is_proposed_as_the_study_plays_its_own(tmp_path: Path) -> None:
    """Moves one way excite too little, for which a diagnosis proposes a recording."""
    with FmuTwin(AXIS) as twin:
        found = complete(
            twin, {}, played({"gravity_torque.sine": 0.3}, np.inf)[:2], tmp_path / "1", seed=0
        )
    assert found is not None
    assert "These recordings cannot tell more" in found.sentence
    assert "next.csv" not in found.sentence


def test_its_parameters_can_be_estimated_on(
    completed: tuple[Completion, list[Recording]],
) -> None:
    found, _ = completed
    for scalar in found.scalars:
        assert scalar.low <= scalar.nominal <= scalar.high
        assert scalar.name in found.twin.binding.parameters
    assert any(name in found.sentence for name in ("riction", "friction"))


@pytest.mark.slow
def test_negative_control_nothing_is_completed_where_nothing_is_missing(tmp_path: Path) -> None:
    with FmuTwin(AXIS) as twin:
        assert complete(twin, {}, played({})[:2], tmp_path / "00001", seed=0) is None
    assert not (tmp_path / "00001").exists()
