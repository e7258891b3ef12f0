"""Diagnoses made by hand that name one effect each, with what it takes to compensate it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from gmfbo.diagnosis import Diagnosis
from gmfbo.diagnosis.result.named_effect import IdentifiedValue, NamedEffect
from gmfbo.diagnosis.result.predictions import Explanation, Predictions, Span
from gmfbo.physics import CATALOGUE
from tests.diagnosis.example_diagnoses import friction, nothing

SPANS = {
    "position": Span(-0.5, 0.5, "rad"),
    "velocity": Span(-4.0, 4.0, "rad/s"),
    "command": Span(-2.0, 2.0, "N.m"),
    "current": Span(-2.0, 2.0, "N.m"),
    "load": Span(0.0, 2.0, "N.m"),
    "torque": Span(-2.0, 2.0, "N.m"),
}

VALUES: Mapping[str, Mapping[str, float]] = {
    "coulomb_friction": {"level": 0.2},
    "asymmetric_friction": {
        "level_positive": 0.2,
        "level_negative": 0.1,
        "viscous_difference": 0.01,
    },
    "stribeck_friction": {"level": 0.1, "breakaway": 0.3, "velocity": 0.2},
    "viscous_friction": {"coefficient": 0.02},
    "quadratic_drag": {"coefficient": 0.01},
    "presliding_friction": {"level": 0.2, "deflection": 0.003},
    "hysteresis": {"level": 0.2, "deflection": 0.05},
    "load_dependent_friction": {"level": 0.1, "coefficient": 0.05},
    "position_dependent_friction": {"level": 0.2, "sine": 0.05, "cosine": 0.03, "wavenumber": 9.0},
    "backlash": {"gap": 0.004, "load_inertia": 0.003},
    "cogging_torque": {"sine_1": 0.08, "cosine_1": -0.05, "wavenumber_1": 24.0},
    "torque_ripple": {"sine_1": 0.05, "cosine_1": 0.02, "wavenumber_1": 12.0},
    "gravity_torque": {"sine": 0.3, "cosine": 0.4},
    "elastic_return": {"stiffness": 0.3, "preload": 0.1},
    "constant_torque_offset": {"level": -0.15},
    "load_inertia": {"inertia": 0.004},
    "actuator_dead_zone": {"width": 0.1},
    "actuator_gain_loss": {"loss": 0.2},
    "magnetic_saturation": {"coefficient": 0.15},
}
"""Values of every effect that a feed-forward cancels."""


def diagnosis_of(values: Mapping[str, Mapping[str, float]]) -> Diagnosis:
    """A diagnosis that names these effects at these values; none without any."""
    effects = tuple(
        NamedEffect(
            name=name,
            port=CATALOGUE[name].port,
            probability=0.9,
            statement=f"{name} is missing from the twin.",
            equation=CATALOGUE[name].equation,
            parameters={key: IdentifiedValue(v, "1", 0.9 * v, 1.1 * v) for key, v in own.items()},
            evidence=400.0,
            threshold=30.0,
            evidence_per_recording={},
        )
        for name, own in values.items()
    )
    physics = {f"{name}.{key}": v for name, own in values.items() for key, v in own.items()}
    told = Predictions(
        (Explanation(" + ".join(values) or "parameters", tuple(values), {}, physics, 1.0),),
        30.0,
        {"position": 3e-5, "torque_command": 0.02},
        SPANS,
        (),
    )
    return replace(friction() if values else nothing(), effects=effects, predictions=told)
