"""Six gains of a cascade controller on the drive, some log-scaled, one an integer-valued limit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.space import Gain, GainSpace
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.tuner import Tuner

TWIN = """
name = "drive under a cascade"
step = 1e-3

[fmus]
controller = {{ kind = "cascade_p_pi", sample_time = 1e-3, u_min = -150.0, u_max = 150.0 }}
plant = "{models}/drive_plant.fmu"

[wires]
"plant.torque_command" = "controller.u"
"controller.measured" = "plant.motor_position"
"controller.measured_load" = "plant.position"

[inputs]
reference = "controller.reference"

[outputs]
position = "plant.position"

[initial]
"plant.initial.position" = 0.0
"""

STUDY = """
method = "bo_ei"
[is1]
twin = "drive.toml"
[is2]
twin = "drive.toml"
parameters = { "plant.load.inertia" = 0.2 }
[gains]
"controller.kp" = { low = 2.0, high = 40.0, scale = "log" }
"controller.kv" = { low = 1.0, high = 10.0, scale = "log" }
"controller.ki" = { low = 0.1, high = 30.0, scale = "log" }
"controller.filter_time" = { low = 2e-4, high = 5e-3, scale = "log" }
"controller.anti_windup_gain" = [0.0, 20.0]
"controller.velocity_limit" = { low = 3, high = 12, integer = true }
"controller.feedforward_gain" = 0.0
[reference]
step = 1.0
at = 0.05
horizon = 0.5
[budget]
initial_is1 = 2
initial_is2 = 8
iterations = 3
[objective]
normalise = 8
"""


@pytest.fixture
def study(tmp_path: Path) -> Study:
    models = models_folder().as_posix()
    (tmp_path / "drive.toml").write_text(TWIN.format(models=models), encoding="utf-8")
    (tmp_path / "six.toml").write_text(STUDY, encoding="utf-8")
    return Study.read(tmp_path / "six.toml")


def test_six_gains_are_tuned_and_a_seventh_is_held(study: Study) -> None:
    with Tuner(study) as tuner:
        assert len(tuner.gains.space) == 6
        result = tuner.run()
    assert result.best is not None
    for trial in study.trials:
        limit = trial.gains["controller.velocity_limit"]
        assert limit == round(limit)
        assert 3 <= limit <= 12
        assert trial.gains["controller.feedforward_gain"] == 0.0
    assert len({tuple(trial.gains.values()) for trial in study.trials}) == len(study.trials)
    assert len({trial.objective for trial in study.trials}) > 8


def test_a_log_scale_puts_as_many_points_into_each_decade() -> None:
    log = GainSpace((Gain("k", 1e-3, 1.0, "log"),)).latin_hypercube(300, np.random.default_rng(0))
    assert np.histogram(np.log10(log), [-3, -2, -1, 0])[0].tolist() == [100, 100, 100]


def test_negative_control_a_linear_scale_puts_nearly_all_into_the_last() -> None:
    linear = GainSpace((Gain("k", 1e-3, 1.0),)).latin_hypercube(300, np.random.default_rng(0))
    assert np.histogram(np.log10(linear), [-3, -2, -1, 0])[0][2] >= 269


def test_negative_control_without_the_word_integer_gains_are_fractions(tmp_path: Path) -> None:
    models = models_folder().as_posix()
    (tmp_path / "drive.toml").write_text(TWIN.format(models=models), encoding="utf-8")
    text = STUDY.replace(", integer = true", "").replace("iterations = 3", "iterations = 0")
    (tmp_path / "six.toml").write_text(text, encoding="utf-8")
    fractions = Study.read(tmp_path / "six.toml")
    with Tuner(fractions) as tuner:
        tuner.run()
    limits = np.array([t.gains["controller.velocity_limit"] for t in fractions.trials])
    assert np.all(limits != np.round(limits))
