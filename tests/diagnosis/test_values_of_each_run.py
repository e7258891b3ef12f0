"""An axis that differs a little from run to run lacks nothing, and hides nothing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import pytest

from gmfbo.diagnosis.naming.decision import Decision
from tests.diagnosis.short_recordings import (
    SERVO,
    decided,
    moves,
    multisine,
    open_small,
    triangle,
)

LAWS = ("coulomb_friction", "stribeck_friction", "load_dependent_friction", "torque_ripple")
RUNS = ((0.051, 0.0102, multisine), (0.066, 0.0104, moves), (0.057, 0.0107, triangle))
"""Viscous friction [N m s/rad], inertia [kg m2] and reference of each recording."""

pytestmark = pytest.mark.slow


def decision_on(physics: Mapping[str, float]) -> Decision:
    recordings = []
    for k, (viscous, inertia, reference) in enumerate(RUNS):
        axis = replace(SERVO, truth={"viscous": viscous, "inertia": inertia})
        (one,) = axis.recordings(physics, [reference], seed=k)
        recordings.append(replace(one, name=f"rec{k}.csv"))
    case = open_small(SERVO.twin(), recordings)
    with case.simulations:
        return decided(case, LAWS)


def test_values_that_change_from_run_to_run_are_no_missing_physics() -> None:
    decision = decision_on({})
    assert not decision.rounds
    assert not decision.freed
    assert not decision.is_outside
    spreads = decision.compared.ledger.errors.spreads
    assert 0.05 < spreads["viscous"] / 0.058 < 0.3


def test_friction_is_found_beside_them() -> None:
    decision = decision_on({"coulomb_friction.level": 0.2})
    assert [found.winner.name for found in decision.rounds] == ["coulomb_friction"]
    level = decision.row.hypothesis.effects[0].values["level"]
    assert level == pytest.approx(0.2, rel=0.02)
    assert decision.row.parameters["viscous"] == pytest.approx(0.058, rel=0.15)
