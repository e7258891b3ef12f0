"""Which fixed parameters compete, and about which values."""

from __future__ import annotations

import pytest

from gmfbo import FmuTwin, models_folder
from gmfbo.diagnosis.comparison.starting import fixed_parameters
from gmfbo.diagnosis.comparison.starting.fixed_parameters import changeable, slightly_changed
from tests.diagnosis.short_recordings import Axis, moves, open_small


def freed(model: str, **changes: object) -> dict[str, float]:
    with FmuTwin(models_folder() / f"{model}.toml") as twin:
        return {
            one.name: one.nominal
            for one in changeable(twin.with_file(twin.file.model_copy(update=changes)), ())
        }


def test_values_given_to_a_twin_stand_for_those_of_its_fmu() -> None:
    """A friction that was set to zero was freed about that of the FMU, which it had hidden."""
    given = {"friction.coulomb": 0.0, "friction.stribeck": 0.5}
    with FmuTwin(models_folder() / "drive_twin.toml", parameters=given) as twin:
        found = {one.name: one for one in changeable(twin, ())}
    assert "friction.coulomb" not in found
    assert found["friction.stribeck"].nominal == 0.5
    assert found["friction.presliding"].nominal == 1e-3


def test_near_the_end_of_what_an_fmu_allows_a_parameter_is_changed_the_other_way() -> None:
    """0.97 times 1.05 is no duty."""
    given = {"servo.duty_limit": 0.97}
    with FmuTwin(models_folder() / "servo_pendulum.toml", parameters=given) as twin:
        found = {one.name: slightly_changed(one) for one in changeable(twin, ())}
    assert found["servo.duty_limit"] == pytest.approx(0.97 / 1.05)


def test_what_an_fmu_declares_fixed_competes_and_what_belongs_to_the_simulation_does_not() -> None:
    """`fixed` means during a run: exporters that know no other word gave nothing to free."""
    found = freed("drive_twin")
    assert {"motor.flux", "gear.ratio"} <= found.keys()
    assert not [n for n in found if "sample" in n or "initial" in n or "[" in n]


def test_parameters_of_fmi_3_compete_too() -> None:
    assert freed("linear_axis", fmu="linear_axis_fmi3.fmu") == freed("linear_axis") != {}


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("ctl.sample_time", ["ctl", "sample", "time"]),
        ("sampleTime", ["sample", "time"]),
        ("plant.resampler", ["plant", "resampler"]),
    ],
)
def test_words_of_a_name(name: str, words: list[str]) -> None:
    assert fixed_parameters._words(name) == words


def test_of_too_many_those_compete_that_move_the_signals(monkeypatch: pytest.MonkeyPatch) -> None:
    axis = Axis(model="demo_axis", truth={}, gains={}, noise={"position": 1e-5})
    case = open_small(axis.twin(), axis.recordings({}, (moves,), seconds=0.5))
    with case.simulations:
        every = {one.name for one in fixed_parameters.fixed_parameters(case, ())}
        monkeypatch.setattr(fixed_parameters, "_MOST", len(every) - 1)
        chosen = {one.name for one in fixed_parameters.fixed_parameters(case, ())}
    # Neither contact nor ripple nor hum acts in this twin: their shapes change nothing.
    assert every - chosen >= {"contact.stiffness", "ripple.cycles", "hum.frequency"}
    assert {"filter_time", "torque_lag"} <= chosen
