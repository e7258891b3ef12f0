"""A law is not believed for want of others that explain as much and were not looked at."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.naming.decided_by_score import decide
from tests.diagnosis.short_recordings import BENCH, open_small

LARGER = (
    "stribeck_friction",
    "presliding_friction",
    "load_dependent_friction",
    "position_dependent_friction",
    "elastic_return",
)
SAME = {"coulomb_friction", "constant_torque_offset", "actuator_dead_zone"}
"""What an axis that only ever moves one way cannot tell apart."""


COUNTED = replace(BENCH, noise={"position": 2e-3})


def steps_forward(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """[A] Steps between two levels, both far above the friction."""
    return 1.8 + 1.2 * np.sin(2.0 * np.pi * 1.7 * t**1.5 + 1.0).round()


def test_one_way_friction_dead_zone_and_constant_torque_are_one_set() -> None:
    """They gain as much as friction does; larger friction laws gain more, and were fitted first."""
    physics = {"coulomb_friction.level": 0.11, "coulomb_friction.deflection": 1e-4}
    physics["transport_delay.delay"] = 8e-3
    recordings = [
        replace(own, use=(0.4, float(own.time[-1])))
        for own in COUNTED.recordings(physics, (steps_forward, steps_forward))
    ]
    case = open_small(BENCH.twin(), recordings)
    try:
        testable = (*LARGER, *SAME, "transport_delay")
        decision = decide(case, testable, (), lambda stage, share: None)
    finally:
        case.simulations.close()
    assert {"transport_delay"} in [set(found.names) for found in decision.rounds]
    assert SAME in [set(found.names) for found in decision.rounds]
