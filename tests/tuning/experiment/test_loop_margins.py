"""Margins by a multisine on the twin, against python-control on the same linear loop."""

from __future__ import annotations

from collections.abc import Mapping

import control
import pytest

from gmfbo import FmuTwin, models_folder
from gmfbo.recordings.reference import step_reference
from gmfbo.tuning.experiment.loop_margins import FINER, LoopMargins, MarginMeter, differing

SERVO = models_folder() / "servo_axis.toml"
STEP = 1e-3


def measured(gains: Mapping[str, float], parameters: Mapping[str, float]) -> LoopMargins:
    fine, coarse = (
        FmuTwin(SERVO, parameters=parameters, step=step, driven_ports=("command",), isolated=False)
        for step in (STEP / FINER, STEP)
    )
    reference = step_reference(1.0, at=0.05, horizon=1.0)
    meter = MarginMeter(fine, coarse, reference, "torque_command", horizon=1.0, step=STEP)
    found = meter.measure(gains)
    fine.close()
    coarse.close()
    return found


def by_python_control(gains: Mapping[str, float]) -> tuple[float, float, float]:
    """Margins of the servo axis: PD with filtered difference at 1 kHz, lag, inertia, friction."""
    lag, inertia, viscous, filter_time = 5e-4, 0.01, 0.05, 1e-3
    plant = control.tf([1.0], [lag, 1.0]) * control.tf([1.0], [inertia, viscous, 0.0])
    rate = control.tf([1.0, -1.0], [filter_time + STEP, -filter_time], STEP)
    loop = control.c2d(plant, STEP, "zoh") * (gains["kp"] + gains["kd"] * rate)
    factor, phase, distance, *_ = control.stability_margins(loop, method="frd")
    return float(factor), float(phase), 1.0 / float(distance)


@pytest.mark.parametrize("gains", [{"kp": 40.0, "kd": 0.8}, {"kp": 60.0, "kd": 0.4}])
def test_margins_of_a_linear_twin_are_those_of_python_control(gains: dict[str, float]) -> None:
    factor, phase, peak = by_python_control(gains)
    found = measured(gains, {"torque_limit": 1e4})
    assert found.values["phase_margin"] == pytest.approx(phase, abs=0.2)
    assert found.values["gain_margin"] == pytest.approx(factor, rel=0.01)
    assert found.values["ms"] == pytest.approx(peak, rel=0.005)
    assert differing(found) == []


def test_an_unstable_loop_has_no_margin() -> None:
    gains = {"kp": 40.0, "kd": 20.0}  # ten times the derivative gain that the lag bears
    assert by_python_control(gains)[0] < 1.0
    found = measured(gains, {"torque_limit": 1e4})
    assert found.values["phase_margin"] == 0.0


def test_margins_that_depend_on_the_size_are_told_at_both() -> None:
    small = {"phase_margin": 50.0, "gain_margin": 4.0, "ms": 1.50}
    large = {"phase_margin": 40.0, "gain_margin": 4.2, "ms": 1.55}
    (told,) = differing(LoopMargins(small, (0.2, 0.4), (small, large)))
    assert told == "phase margin 50 at a multisine of 0.2 RMS, 40 at 0.4"
