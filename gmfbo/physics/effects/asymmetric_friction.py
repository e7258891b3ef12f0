"""Asymmetric friction: more friction in one direction than in the other."""

import numpy as np

from gmfbo.physics import friction
from gmfbo.physics.effect import Effect, Units, Values, sentence, signed
from gmfbo.physics.excitation import Excitation
from gmfbo.physics.states import Array, States
from gmfbo.units import quantity


def _signal(states: States, parameters: Values) -> Array:
    direction = states.direction
    levels = np.where(direction > 0.0, parameters["level_positive"], parameters["level_negative"])
    viscous = 0.5 * parameters.get("viscous_difference", 0.0) * np.abs(states.velocity)
    return np.asarray(-levels * direction - viscous, dtype=np.float64)


def _largest(parameters: Values, excitation: Excitation) -> float:
    """Friction at the largest recorded speed, in the direction that has more of it."""
    levels = max(parameters["level_positive"], parameters["level_negative"])
    return levels + 0.5 * abs(parameters.get("viscous_difference", 0.0)) * excitation.speed


def _statement(parameters: Values, units: Units, place: str) -> str:
    """Both levels, and by how much viscous friction differs, which may be all that differs."""
    levels = sentence(
        "Friction that differs by direction {place} is missing from the twin: about "
        "{level_positive} in positive and {level_negative} in negative direction",
        level_positive="torque",
        level_negative="torque",
    )(parameters, units, place)
    difference = parameters.get("viscous_difference", 0.0)
    if difference == 0.0:
        return f"{levels}."
    more = "more" if difference > 0.0 else "less"
    viscous = quantity(abs(difference), units.resolve("torque/velocity"))
    return f"{levels}, and {viscous} {more} of viscous friction in positive direction."


asymmetric_friction = Effect(
    name="asymmetric_friction",
    port="torque",
    family="friction",
    signal_path="plant",
    parameters=(
        friction.level("Level at positive velocity", "level_positive"),
        friction.level("Level at negative velocity", "level_negative"),
        signed(
            "viscous_difference",
            "Viscous coefficient at positive less that at negative velocity",
            "torque/velocity",
            lambda e: e.torque / e.speed,
        ),
    ),
    fixed=friction.fixed_deflection,
    own_nuisances=(friction.own_deflection(),),
    starts=lambda e: [
        {
            "level_positive": 0.08 * e.torque,
            "level_negative": 0.05 * e.torque,
            "viscous_difference": 0.01 * e.torque / e.speed,
        }
    ],
    size=_largest,
    size_name="level",
    size_unit="torque",
    floor=friction.floor,
    not_excited=friction.no_reversal,
    shows_at_turns=True,
    signal=_signal,
    feature=lambda states: _signal(states, {"level_positive": 1.0, "level_negative": 0.5}),
    acts=friction.acts_at_reversals,
    region=friction.reversal_region,
    region_state="velocity",
    statement=_statement,
    equation="tau = -F_p - d/2 * omega if omega > 0, +F_n + d/2 * omega if omega < 0",
    source="Armstrong-Hélouvry, 1991",
    contains=("coulomb_friction",),
    as_limit={"level_positive": "level", "level_negative": "level"},
    confused_with={
        "coulomb_friction": "motion in both directions at equal speeds",
        "constant_torque_offset": "standstill: an offset is still there, friction only yields",
        "gravity_torque": "a full turn: gravity changes with the position",
    },
)
