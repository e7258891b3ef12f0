"""A lag of the actuator does to a linear loop what one of the sensor does: both are said."""

from __future__ import annotations

import numpy as np
import pytest

from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.diagnosis.naming.candidate_fits import shortlist
from gmfbo.diagnosis.screening.probes import Probe, Screened
from gmfbo.physics import CATALOGUE
from tests.diagnosis.short_recordings import SERVO, decided, moves, multisine, open_small, triangle
from tests.physics.excitations import TYPICAL


def screened_of(name: str, gain: float) -> Screened:
    """One effect by its first start, with what it explains; kept where that is anything."""
    values = dict(CATALOGUE[name].starts(TYPICAL)[0])
    width = len(values)
    probe = Probe(Candidate(name, values), tuple(values), (1.0,) * width, (False,) * width, [])
    kept = tuple(range(width)) if gain else ()
    return Screened(probe, kept, np.ones(width), gain, 1.0, gain)


@pytest.mark.slow
def test_a_lag_at_one_end_has_that_at_the_other_as_its_rival() -> None:
    lags = ("actuator_lag", "sensor_lag")
    recordings = SERVO.recordings(
        {"actuator_lag.time": 2e-3}, (multisine, moves, triangle), seconds=1.5
    )
    case = open_small(SERVO.twin(), recordings)
    with case.simulations:
        (found,) = decided(case, lags).rounds
    assert {found.winner.name, *(rival.name for rival in found.rivals)} == set(lags)


def test_the_other_end_is_fitted_though_screening_saw_nothing_in_it() -> None:
    screened = [screened_of("actuator_lag", 100.0), screened_of("sensor_lag", 0.0)]
    assert {c.effect for c in shortlist(screened, 8.0)} == {"actuator_lag", "sensor_lag"}


def test_relatives_of_the_best_friction_law_are_fitted_too() -> None:
    gains = {
        "presliding_friction": 200.0,
        "stribeck_friction": 190.0,
        "position_dependent_friction": 180.0,
        "asymmetric_friction": 170.0,
        "hysteresis": 20.0,
        "quadratic_drag": 19.0,
    }
    chosen = shortlist([screened_of(name, gain) for name, gain in gains.items()], 8.0)
    assert "hysteresis" in {c.effect for c in chosen}
    assert "quadratic_drag" not in {c.effect for c in chosen}
