"""A study on real FMUs: the linear axis, its twin with a wrong mass, and a change of the plant."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from gmfbo import FmuTwin
from gmfbo.errors import InputError, StudyFileError
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.tuning.experiment.experiment import ReferenceExperiment
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.tuner import Tuner
from tests.tuning.methods.quick_methods import QUICK

TWIN = models_folder() / "linear_axis.toml"

STUDY = """
name = "linear"
method = "{method}"
[is1]
twin = {twin}
{plant}
[is2]
twin = {twin}
parameters = {{ mass = 150.0 }}
[gains]
{gains}
[reference]
step = 0.01
at = 0.05
horizon = 0.4
[budget]
iterations = {iterations}
"""


def write(
    folder: Path, *, method: str = "random", plant: str = "", gains: str = "", iterations: int = 2
) -> Study:
    path = folder / "linear.toml"
    path.write_text(
        STUDY.format(
            method=method,
            twin=json.dumps(TWIN.as_posix()),
            plant=plant,
            gains=gains,
            iterations=iterations,
        ),
        encoding="utf-8",
    )
    return Study.read(path)


def position(study: Study, trial_number: int, **parameters: float) -> np.ndarray:
    """What the FMU alone does at the gains of a trial."""
    trial = study.trials[trial_number - 1]
    experiment = ReferenceExperiment.from_section(
        study.file.reference, "position", folder=study.origin, unit="m"
    )
    with FmuTwin(TWIN, isolated=False) as twin:
        run = twin.run(trial.gains, experiment.reference, parameters=parameters)
    return run.signal("position")


def test_each_source_runs_with_its_own_parameters(tmp_path: Path) -> None:
    study = write(tmp_path)
    with Tuner(study) as tuner:
        tuner.run()
    twin, real = study.trials[0], study.trials[10]
    assert (twin.source, real.source) == ("IS2", "IS1")
    np.testing.assert_array_equal(twin.recording.signal("position"), position(study, 1, mass=150.0))
    np.testing.assert_array_equal(real.recording.signal("position"), position(study, 11))
    assert twin.recording.units["position"] == "m"
    assert len({twin.twin, real.twin, ""}) == 3


def test_the_plant_changes_for_good_after_its_run(tmp_path: Path) -> None:
    study = write(
        tmp_path, plant="change = { after_runs = 3, parameters = { viscous_friction = 900.0 } }"
    )
    with Tuner(study) as tuner:
        tuner.run()
    for number in (11, 12, 13):
        np.testing.assert_array_equal(
            study.trials[number - 1].recording.signal("position"), position(study, number)
        )
    np.testing.assert_array_equal(
        study.trials[13].recording.signal("position"),
        position(study, 14, viscous_friction=900.0),
    )
    assert study.trials[13].twin != study.trials[12].twin


def test_a_study_with_runs_around_real_ones_finds_better_gains_than_it_began_with(
    tmp_path: Path,
) -> None:
    study = write(tmp_path, method="gmfbo", iterations=2)
    with Tuner(study, method=QUICK["gmfbo"]) as tuner:
        result = tuner.run()
    initial = [trial.objective for trial in study.trials if trial.source == "IS1"][:2]
    assert result.best is not None
    assert result.best.objective <= min(initial)
    around = [trial for trial in study.trials if trial.source == "IS2" and trial.parent is not None]
    assert len(around) > len([trial for trial in study.trials if trial.source == "IS1"])


def test_a_number_fixes_a_gain_in_every_run(tmp_path: Path) -> None:
    study = write(tmp_path, gains="kv = 300.0")
    with Tuner(study) as tuner:
        tuner.run()
    assert {trial.gains["kv"] for trial in study.trials} == {300.0}
    assert len({trial.gains["kp"] for trial in study.trials}) == 14


def test_a_gain_that_the_fmu_lacks_is_refused_before_any_run(tmp_path: Path) -> None:
    with pytest.raises(StudyFileError, match=r"no FMU parameter 'kpp'; did you mean 'kp'"):
        Tuner(write(tmp_path, gains="kpp = [1.0, 2.0]"))


def test_a_parameter_that_the_fmu_lacks_is_refused(tmp_path: Path) -> None:
    study = write(tmp_path, plant="parameters = { mas = 3.0 }")
    with pytest.raises(InputError, match="'mass'"), Tuner(study) as tuner:
        tuner.run()


def test_a_plant_of_ones_own_cannot_change_by_the_study_file(tmp_path: Path) -> None:
    study = write(tmp_path, plant="change = { after_runs = 1, parameters = { mass = 2.0 } }")
    with (
        FmuTwin(TWIN) as own,
        pytest.raises(StudyFileError, match=r"only a plant given as twin = FILE can change"),
    ):
        Tuner(study, is1=own)
