"""The words of a twin file, without its FMU: what a reader asks of a twin."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from gmfbo.recordings import SignalSpec


@dataclass(frozen=True)
class TwinWords:
    """Signals by name, and FMU parameters with whether they may change during a run."""

    signals: tuple[SignalSpec, ...]
    parameters: Mapping[str, bool] = field(default_factory=dict)

    def signal_specs(self) -> Mapping[str, SignalSpec]:
        return {spec.name: spec for spec in self.signals}

    def parameter_tunable(self) -> Mapping[str, bool]:
        return self.parameters


AXIS = TwinWords(
    signals=(
        SignalSpec("reference", "reference", unit="rad", required=True),
        SignalSpec("position", "position", unit="rad"),
        SignalSpec("speed", "speed", unit="rad/s"),
        SignalSpec("torque_command", "torque_command", unit="N.m"),
    ),
    parameters={"ctl.Kp": True, "mech.J": False},
)
