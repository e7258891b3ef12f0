"""Friction below its floor is named down to half of it, where it shows clearly."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.naming.decision import Decision
from gmfbo.physics import CATALOGUE
from tests.diagnosis.short_recordings import SERVO, decided, moves, multisine, open_small, triangle

QUIET = replace(SERVO, noise={"position": 2e-6, "torque_command": 0.002})
FLOOR = 2.07e-4  # [N m] of these recordings; the test holds it against the catalogue's


def tremble(t: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(0.05 * multisine(t))


def decided_on(share: float) -> Decision:
    level = {"coulomb_friction.level": share * FLOOR, "coulomb_friction.deflection": 1e-6}
    recordings = QUIET.recordings(level, (triangle, moves, tremble), seconds=2.0)
    case = open_small(QUIET.twin(), recordings)
    with case.simulations:
        floor = CATALOGUE["coulomb_friction"].floor(case.setting.excitation)
        assert floor == pytest.approx(FLOOR, rel=0.01)
        return decided(case, ("coulomb_friction", "sensor_lag"))


def test_seven_tenths_of_the_floor_are_named_where_the_gain_is_twice_what_it_has_to_be() -> None:
    decision = decided_on(0.7)
    (only,) = decision.rounds
    assert only.winner.name == "coulomb_friction"
    assert 2.0 < only.winner.gain / only.needed < 10.0


@pytest.mark.slow
def test_less_than_half_of_the_floor_is_not_named_however_it_shows() -> None:
    decision = decided_on(0.4)
    assert not decision.rounds
    assert decision.too_small is not None
    assert decision.too_small.name == "coulomb_friction"
