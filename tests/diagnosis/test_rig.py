"""What columns may be off by: a command is a number in a controller, a force is measured."""

from __future__ import annotations

from gmfbo import FmuTwin
from gmfbo.diagnosis.rig import describe_rig
from gmfbo.sources.models import models_folder


def test_a_command_has_no_zero_error_and_a_measured_force_has_one() -> None:
    """The zero of a sensor would hide the constant force that an integral part holds."""
    found = {}
    for name, signal in (("servo_axis", "torque_command"), ("damper", "force")):
        twin = FmuTwin(models_folder() / f"{name}.toml")
        found[signal] = describe_rig(twin.binding, []).alignments[signal]
    assert found["torque_command"].offset == 0.0
    assert found["force"].offset
    assert found["torque_command"].scale == found["force"].scale
