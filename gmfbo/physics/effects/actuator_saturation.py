"""Saturation: the actuator gives no more than a limit."""

import numpy as np

from gmfbo.physics import limits
from gmfbo.physics.effect import Effect, EffectParameter, sentence
from gmfbo.physics.states import Array, States
from gmfbo.units import quantity


def _feature(states: States) -> Array:
    largest = float(np.max(np.abs(states.command)))
    cut = limits.clipped(states.command, 0.8 * largest)
    return cut / max(0.2 * largest, np.finfo(float).tiny)


actuator_saturation = Effect(
    name="actuator_saturation",
    port="command",
    family="limit",
    signal_path="actuator",
    parameters=(
        EffectParameter(
            "limit",
            "Limit of the command",
            "command",
            low=lambda e: 0.05 * e.command,
            high=lambda e: 1.5 * e.command,
            scale=lambda e: 0.2 * e.command,
        ),
    ),
    starts=lambda e: [{"limit": share * e.largest_demand(0.0)} for share in limits.SHARES],
    more_starts=lambda e: [{"limit": s * e.largest_demand(0.0)} for s in limits.MORE_SHARES],
    gone=lambda p, e: {"limit": e.largest_demand(0.0)},
    size=lambda p, e: max(0.0, e.command - p["limit"]),
    size_name="cut",
    size_unit="command",
    floor=limits.cut_floor,
    signal=lambda states, p: limits.clipped(states.command, p["limit"]),
    feature=_feature,
    acts=lambda states, p: limits.beyond(states.command, p["limit"]),
    region=lambda p, units: f"where the command is beyond {quantity(p['limit'], units.command)}",
    region_state="command",
    statement=sentence(
        "The actuator saturates at about {limit}, which is missing from the twin.",
        limit="command",
    ),
    equation="u_out = min(max(u, -u_max), u_max)",
    source="Åström and Rundqwist, 1989",
    confused_with={
        "supply_voltage_limit": "peaks at low and at high speed: a supply limit falls with speed",
        "actuator_rate_limit": "slow large commands, which a rate limit passes",
        "magnetic_saturation": "middle commands: a limit leaves them alone",
        "thermal_derating": "early peaks: derating comes with time",
    },
)
