"""Stribeck friction: more friction at low speed than while sliding fast."""

import numpy as np

from gmfbo.physics import friction
from gmfbo.physics.effect import Effect, EffectParameter, Units, Values
from gmfbo.physics.excitation import Excitation
from gmfbo.physics.states import Array, Mask, States
from gmfbo.units import quantity


def _signal(states: States, parameters: Values) -> Array:
    slow = np.exp(-((states.velocity / parameters["velocity"]) ** 2))
    excess = parameters["breakaway"] - parameters["level"]
    return -(parameters["level"] + excess * slow) * states.direction


def _feature(states: States) -> Array:
    speed = max(0.1 * float(np.max(np.abs(states.velocity))), np.finfo(float).tiny)
    return _signal(states, {"level": 1.0, "breakaway": 1.5, "velocity": speed})


def _starts(excitation: Excitation) -> list[Values]:
    level = 0.07 * excitation.torque
    return [
        {"level": level, "breakaway": 1.5 * level, "velocity": share * excitation.speed}
        for share in (0.02, 0.08, 0.3)
    ]


def _acts(states: States, parameters: Values) -> Mask:
    return states.near_reversals() | (
        (np.abs(states.velocity) < 1.5 * parameters["velocity"])
        & (np.abs(states.velocity) > states.rest)
    )


def _statement(parameters: Values, units: Units, place: str) -> str:
    level = quantity(parameters["level"], units.torque)
    breakaway = quantity(parameters["breakaway"], units.torque)
    velocity = quantity(parameters["velocity"], units.velocity)
    if parameters["breakaway"] < parameters["level"]:
        return (
            f"Friction that rises with speed {place} is missing from the twin: about {breakaway} "
            f"at low speed, {level} when sliding well above {velocity}."
        )
    return (
        f"Stribeck friction {place} is missing from the twin: about {breakaway} at low speed, "
        f"{level} when sliding well above {velocity}."
    )


stribeck_friction = Effect(
    name="stribeck_friction",
    port="torque",
    family="friction",
    signal_path="plant",
    parameters=(
        friction.level("Coulomb level"),
        friction.level("Breakaway level", "breakaway"),
        EffectParameter(
            "velocity",
            "Stribeck velocity",
            "velocity",
            low=lambda e: 0.003 * e.speed,
            high=lambda e: 0.8 * e.speed,
            scale=lambda e: 0.05 * e.speed,
        ),
    ),
    fixed=friction.fixed_deflection,
    own_nuisances=(friction.own_deflection(),),
    starts=_starts,
    size=lambda p, e: max(p["level"], p["breakaway"]),
    size_name="breakaway",
    size_unit="torque",
    floor=friction.floor,
    not_excited=friction.no_reversal,
    signal=_signal,
    feature=_feature,
    acts=_acts,
    region=lambda p, units: "where the velocity is low and changes sign",
    region_state="velocity",
    statement=_statement,
    equation="tau = -(F_c + (F_s - F_c) * exp(-(omega/omega_s)^2)) * sign(omega)",
    source="Stribeck, 1902; in this form Bo and Pavelescu, 1982",
    contains=("coulomb_friction",),
    as_limit={"level": "level", "breakaway": "level"},
    confused_with={
        "coulomb_friction": "the friction at low speed: reversals at several speeds",
        "presliding_friction": "micro-steps below breakaway, which only presliding answers",
        "viscous_friction": "high constant speeds, where only viscous friction still grows",
    },
)
