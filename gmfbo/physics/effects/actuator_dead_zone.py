"""Dead zone: small commands have no effect."""

import numpy as np

from gmfbo.physics import limits
from gmfbo.physics.effect import Effect, Values, positive, sentence
from gmfbo.physics.states import Array, States
from gmfbo.units import quantity


def _signal(states: States, parameters: Values) -> Array:
    width = parameters["width"]
    return -np.clip(states.command, -width, width)


def _feature(states: States) -> Array:
    width = max(0.05 * float(np.max(np.abs(states.command))), np.finfo(float).tiny)
    return _signal(states, {"width": width}) / width


actuator_dead_zone = Effect(
    name="actuator_dead_zone",
    port="command",
    family="limit",
    signal_path="actuator",
    parameters=(positive("width", "Half width", "command", lambda e: e.command, most=0.9),),
    starts=lambda e: [{"width": share * e.command} for share in (0.06, 0.008, 0.001)],
    size=lambda p, e: p["width"],
    size_name="width",
    size_unit="command",
    floor=lambda e: 2e-4 * e.command,
    signal=_signal,
    feature=_feature,
    acts=lambda states, p: ~limits.beyond(states.command, 2.0 * p["width"]),
    region=lambda p, units: (
        f"where the command is within {quantity(p['width'], units.command)} of zero"
    ),
    region_state="command",
    statement=sentence(
        "A dead zone of the actuator of about {width} to either side is missing from the twin.",
        width="command",
    ),
    equation="u_out = u - min(max(u, -w), w)",
    source="Tao and Kokotovic, 1994",
    confused_with={
        "coulomb_friction": "where the command changes sign while the axis moves on",
        "actuator_gain_loss": "large commands: a dead zone takes the same from all",
    },
)
