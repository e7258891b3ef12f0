"""A lag that the refitted inertia has made up for is found all the same."""

from __future__ import annotations

from contextlib import closing

import numpy as np
import pytest

from gmfbo.diagnosis.naming import candidate_fits
from gmfbo.diagnosis.naming.forward_selection import decide, groups_of
from gmfbo.diagnosis.screening.probes import probes, screen
from gmfbo.diagnosis.screening.testable_effects import candidates
from tests.diagnosis.servo_recordings import HIDDEN, opened

pytestmark = pytest.mark.slow

DELAY = 2e-3
LAGS = ("transport_delay", "actuator_lag", "sensor_lag")


@pytest.mark.slow
def test_a_delay_is_named_where_its_slope_about_the_refitted_twin_points_below_zero() -> None:
    with closing((case := opened({"transport_delay.delay": DELAY})).simulations):
        library = candidates(LAGS, case.setting.excitation)
        tried = probes(case.misfit, case.base, library)
        screened = screen(case.misfit, case.base, tried, groups_of(case))
        assert case.base.parameters["inertia"] > 1.1 * HIDDEN["inertia"]  # it makes up for it
        assert max(entry.gain for entry in screened) < 1.0  # and hides it from a slope
        decision = decide(case, library, np.random.default_rng(0), lambda stage, share: None)
    assert [entry.winner.name for entry in decision.rounds] == ["transport_delay"]
    found = decision.rounds[0].winner
    assert found.effect.values["delay"] == pytest.approx(DELAY, rel=0.02)
    assert found.fitted.parameters["inertia"] == pytest.approx(HIDDEN["inertia"], rel=0.01)


SHORTER = 1.5e-3


def named_alone() -> list[str]:
    """Names where a delay is hidden that no single step from any start leads to."""
    with closing((case := opened({"transport_delay.delay": SHORTER})).simulations):
        library = candidates(["transport_delay"], case.setting.excitation)
        decision = decide(case, library, np.random.default_rng(0), lambda stage, share: None)
    return [entry.winner.name for entry in decision.rounds]


def test_a_delay_is_found_from_a_start_that_only_a_few_steps_lead_down_from() -> None:
    assert named_alone() == ["transport_delay"]


def test_by_single_steps_it_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    """Negative control."""
    monkeypatch.setattr(candidate_fits, "_lags_beyond", lambda misfit, base, starts: [])
    assert named_alone() == []
