"""Two effects take the place of one that does most of what both do."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import pytest

from gmfbo.diagnosis.naming.decision import Decision
from tests.diagnosis.short_recordings import SERVO, decided, moves, multisine, open_small, triangle

QUIET = replace(SERVO, noise={"position": 2e-6, "torque_command": 0.002})
LIBRARY = (
    "coulomb_friction",
    "asymmetric_friction",
    "elastic_return",
    "constant_torque_offset",
)


def decided_on(physics: Mapping[str, float]) -> Decision:
    recordings = QUIET.recordings(dict(physics), (multisine, moves, triangle), seconds=2.0)
    case = open_small(QUIET.twin(), recordings)
    with case.simulations:
        return decided(case, LIBRARY)


@pytest.mark.slow
def test_friction_and_a_weak_spring_are_no_friction_that_differs_by_direction() -> None:
    hidden = {
        "coulomb_friction.level": 0.004,
        "elastic_return.stiffness": 0.003,
        "elastic_return.preload": -0.003,
    }
    decision = decided_on(hidden)
    first, second = decision.rounds
    assert first.winner.name == "coulomb_friction"
    assert second.winner.name == "elastic_return"


@pytest.mark.slow
def test_friction_that_differs_by_direction_stays_one() -> None:
    """Negative control."""
    decision = decided_on(
        {
            "asymmetric_friction.level_positive": 0.005,
            "asymmetric_friction.level_negative": 0.003,
        }
    )
    (only,) = decision.rounds
    assert only.winner.name == "asymmetric_friction"
