"""Diagnoses made by hand, one for each verdict, with the names and numbers of a small drive."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gmfbo.diagnosis import Diagnosis
from gmfbo.diagnosis.result.curve import Curve
from gmfbo.diagnosis.result.estimated import Alignment, Combination, EstimatedParameter
from gmfbo.diagnosis.result.explained import FreeRun, Remainder, Share
from gmfbo.diagnosis.result.findings import Cost
from gmfbo.diagnosis.result.held_out_errors import Fit, SignalFit
from gmfbo.diagnosis.result.named_effect import (
    DetectableSize,
    IdentifiedValue,
    NamedEffect,
    NotTestable,
    RivalShare,
)
from gmfbo.diagnosis.result.next_experiment import NextExperiment
from gmfbo.diagnosis.result.reference_test import ResidualTest
from gmfbo.diagnosis.result.whereabouts import Location, Shape, TimeWindow

FRICTION = NamedEffect(
    name="coulomb_friction",
    port="torque",
    probability=0.94,
    statement="Coulomb friction of about 0.52 N m at the motor shaft is missing from the twin.",
    equation="tau = -F_c * sign(omega)",
    parameters={"level": IdentifiedValue(0.5213, "N.m", 0.4931, 0.5478)},
    evidence=412.3,
    threshold=18.31,
    evidence_per_recording={"rec2.csv": 111.9, "rec3.csv": 300.4},
)
OFFSET = NamedEffect(
    name="constant_torque_offset",
    port="torque",
    probability=0.52,
    statement=(
        "One of constant torque offset, gravity torque, elastic return is missing from the twin "
        "(the recordings cannot tell them apart)."
    ),
    equation="tau = T_0",
    parameters={"level": IdentifiedValue(0.1071, "N.m", 0.0954, 0.1202)},
    evidence=77.4,
    threshold=18.31,
    evidence_per_recording={"rec2.csv": 40.2, "rec3.csv": 37.2},
    indistinguishable_from=("gravity_torque", "elastic_return"),
    rivals=(
        RivalShare("constant_torque_offset", 0.52),
        RivalShare("gravity_torque", 0.2),
        RivalShare("elastic_return", 0.09),
    ),
)
FIT = Fit(
    fitted_on=("rec0.csv", "rec1.csv"),
    held_out=("rec2.csv", "rec3.csv"),
    signals={
        "position": SignalFit(0.0213, 0.0191, 0.00204, 0.00412, 0.00183),
        "torque_command": SignalFit(0.3127, 0.3018, 0.0604, 0.0911, 0.0507),
    },
    explainable_error_removed=0.981,
)


def curves() -> tuple[Curve, ...]:
    """One held-out recording, 2000 rows, whose friction shows in the torque."""
    time = np.arange(2000, dtype=np.float64) * 1e-3 + 12.0
    torque = np.sin(2.0 * np.pi * (time - 12.0))
    recorded = torque + 0.5 * np.sign(np.cos(2.0 * np.pi * (time - 12.0)))
    recorded[700:720] = np.nan
    return (
        Curve(
            "rec3.csv", "position", "rad", time, 0.1 * torque, 0.098 * torque, 0.099 * torque,
            0.1 * torque,
        ),
        Curve("rec3.csv", "torque_command", "N.m", time, recorded, torque, 1.02 * torque,
              recorded - 0.01),
    )  # fmt: skip


def friction() -> Diagnosis:
    """Friction is missing; everything a diagnosis can hold is there, but a shape."""
    return Diagnosis(
        verdict="missing_physics",
        evidence="sufficient",
        effects=(FRICTION,),
        parameters={
            "mech.J": EstimatedParameter(0.12, 0.1213, "kg.m2", 0.1192, 0.1231),
            "mot.kt": EstimatedParameter(0.071, 0.071, "N.m/A", 0.05, 0.09, identifiable=False),
        },
        combinations=(Combination("mech.J / mot.kt", 1.708, 1.691, 1.722),),
        alignment={"torque_command": Alignment("held", 1.2e-4, 1.013, 0.0)},
        detectable={
            "backlash": DetectableSize("gap", 8.1e-4, "rad"),
            "actuator_lag": DetectableSize("time", 3.4e-4, "s"),
        },
        location=Location(
            "plant",
            "where the velocity changes sign",
            (TimeWindow("rec2.csv", 0.413, 0.472), TimeWindow("rec3.csv", 12.24, 12.29)),
        ),
        fit=FIT,
        shape=None,
        next_experiment=None,
        not_testable=(
            NotTestable("sensor_lag", "the twin has no sensor port"),
            NotTestable("load_inertia", "is parameter mech.J"),
            NotTestable("actuator_saturation", "not excited: the command stays below 31 N m"),
        ),
        cost=Cost(612, 14.23, {"reading": 0.31, "screening the library": 9.02}),
        seed=7,
        versions={"gmfbo": "0.1.0", "numpy": "2.4.6"},
        notes=("excited in one recording only; validated by blocks",),
        residual_tests=(
            ResidualTest("rec3.csv", "position", 0.0188, 0.00031, 0.00042, 0.0003),
            ResidualTest("rec3.csv", "torque_command", 0.2911, 0.0212, 0.0104, 0.0041),
        ),
        curves=curves(),
    )


def rivals() -> Diagnosis:
    """Two effects, one of which has rivals that a next recording would separate."""
    return replace(
        friction(),
        effects=(FRICTION, OFFSET),
        next_experiment=NextExperiment(
            "next.csv",
            ("constant_torque_offset", "gravity_torque"),
            212.4,
            18.3,
            {
                "constant_torque_offset": "the same torque at every angle",
                "gravity_torque": "0.2 N m more torque at 90 deg",
            },
            "a ladder of holds, played twice, tells constant torque offset from gravity torque",
        ),
    )


def remaining() -> Diagnosis:
    """Friction of an open-loop axis that explains most, drifts, and leaves something."""
    free = FreeRun(0.41, 0.32, 0.021)
    position = replace(FIT.signals["position"], free_run=free)
    return replace(
        friction(),
        effects=(replace(FRICTION, share=Share(0.77, 0.71, 0.82)),),
        parameters={
            "mech.J": replace(
                friction().parameters["mech.J"], drifts={"rec0.csv": 0.13, "rec3.csv": 0.1105}
            )
        },
        fit=replace(FIT, signals={**FIT.signals, "position": position}),
        remainder=Remainder(0.23, "torque", "velocity", "rec3.csv 12.4-12.9 s"),
    )


def late() -> Diagnosis:
    """A command logged late, or a delay: either explains the recordings."""
    column = Alignment("held", -2.9e-3, 1.013, 0.0, "transport_delay", {"shift": 28.6})
    return replace(friction(), alignment={"torque_command": column})


def weak() -> Diagnosis:
    """Friction that is more likely than not, and no more."""
    unsure = replace(
        FRICTION,
        probability=0.62,
        statement=FRICTION.statement.replace("is missing", "may be missing"),
    )
    return replace(friction(), effects=(unsure,))


def nothing() -> Diagnosis:
    """A twin that meets its recordings."""
    fit = replace(
        FIT,
        signals={"position": SignalFit(0.0019, 0.0018, float("nan"), float("nan"), 0.0018)},
        explainable_error_removed=None,
    )
    return replace(
        friction(), verdict="none", residual_tests=(), effects=(), fit=fit, location=Location(None)
    )


def parameters() -> Diagnosis:
    """An inertia that was wrong, and nothing else."""
    wrong = EstimatedParameter(0.2, 0.1213, "kg.m2", 0.1192, 0.1231)
    return replace(nothing(), verdict="parameters", parameters={"mech.J": wrong})


def too_narrow() -> Diagnosis:
    """An inertia beyond the range that the twin file gives."""
    beyond = EstimatedParameter(
        0.2, 0.4113, "kg.m2", 0.4032, 0.4191, at_bound="high", bound=0.3, stated="ax7.toml, line 9"
    )
    return replace(parameters(), parameters={"mech.J": beyond})


def outside() -> Diagnosis:
    """A mismatch that has no name."""
    x = np.linspace(-30.0, 30.0, 61)
    y = 0.4 * np.tanh(x / 5.0) * np.cos(x / 9.0)
    return replace(
        friction(),
        verdict="outside_library",
        effects=(),
        shape=Shape(
            "torque", "velocity", tuple(x.tolist()), tuple(y.tolist()),
            tuple((y - 0.05).tolist()), tuple((y + 0.05).tolist()), "rad/s", "N.m",
        ),
    )  # fmt: skip


def with_law() -> Diagnosis:
    """Friction is missing, and the curve inferred without a name has its law over it."""
    x = np.linspace(-30.0, 30.0, 15)
    y, half = -0.52 * np.sign(x), np.where(np.abs(x) > 29.0, 50.0, 0.02)
    across = np.linspace(-30.0, 30.0, 120)
    latent = Shape(
        "torque", "velocity", tuple(x.tolist()), tuple(y.tolist()), tuple((y - half).tolist()),
        tuple((y + half).tolist()), "rad/s", "N.m", "coulomb_friction", tuple(across.tolist()),
        tuple((-0.521 * np.sign(across)).tolist()),
    )  # fmt: skip
    return replace(friction(), latent=latent)


def too_little() -> Diagnosis:
    """Recordings that excite next to nothing."""
    return replace(nothing(), evidence="insufficient", next_experiment=rivals().next_experiment)
