"""Magnetic saturation: the torque falls behind a large current."""

import numpy as np

from gmfbo.physics.effect import Effect, EffectParameter, Units, Values
from gmfbo.physics.excitation import Excitation
from gmfbo.physics.states import Array, Mask, States
from gmfbo.units import quantity


def _signal(states: States, parameters: Values) -> Array:
    saturation = (parameters["coefficient"] * states.command) ** 2
    return -states.command * saturation / (1.0 + saturation)


def _loss(parameters: Values, excitation: Excitation) -> float:
    """Share of the largest command that is lost."""
    saturation = (parameters["coefficient"] * excitation.command) ** 2
    return saturation / (1.0 + saturation)


def _feature(states: States) -> Array:
    largest = max(float(np.max(np.abs(states.command))), np.finfo(float).tiny)
    return -((states.command / largest) ** 2) * states.command


def _acts(states: States, parameters: Values) -> Mask:
    size = np.abs(states.command)
    return np.asarray(size > 0.7 * np.max(size), dtype=np.bool_)


def _statement(parameters: Values, units: Units, place: str) -> str:
    half = 1.0 / max(parameters["coefficient"], 1e-300)
    return (
        "Magnetic saturation of the actuator is missing from the twin: a tenth is lost at about "
        f"{quantity(half / 3.0, units.command)}, half at {quantity(half, units.command)}."
    )


magnetic_saturation = Effect(
    name="magnetic_saturation",
    port="command",
    family="gain",
    signal_path="actuator",
    parameters=(
        EffectParameter(
            "coefficient",
            "Saturation coefficient",
            "1/command",
            low=lambda e: 0.0,
            # Above 1/command, a larger command would give less torque.
            high=lambda e: 0.95 / e.command,
            scale=lambda e: 0.2 / e.command,
        ),
    ),
    starts=lambda e: [{"coefficient": 0.3 / e.command}],
    size=_loss,
    size_name="loss",
    size_unit="1",
    floor=lambda e: 2e-3,
    signal=_signal,
    feature=_feature,
    acts=_acts,
    region=lambda p, units: "where the command is large",
    region_state="command",
    statement=_statement,
    equation="u_out = u / (1 + (c * u)^2)",
    source="Frölich, 1881; here even in the command",
    confused_with={
        "actuator_gain_loss": "small and large commands: a gain takes the same share of both",
        "actuator_saturation": "middle commands: a limit leaves them alone",
        "thermal_derating": "early peaks, which derating passes",
    },
)
