"""What an encoder's counts in the twin make of a small change is taken for no gain."""

from __future__ import annotations

from contextlib import closing

import pytest

from gmfbo.diagnosis.comparison import opened_comparison
from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.moves import ranked, responses
from gmfbo.diagnosis.comparison.numbers import LEAST_GAIN
from gmfbo.diagnosis.comparison.opened_comparison import comparison_of
from tests.diagnosis.fitting.test_rough_twin import DRIVE
from tests.diagnosis.short_recordings import multisine, open_small, triangle

ABSENT = ("coulomb_friction", "actuator_rate_limit", "sensor_scale", "torque_ripple")


def test_changes_measured_beside_the_fit_share_no_counts_with_its_residual(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(opened_comparison, "encoder_counts", lambda case: None)  # they stay
    case = open_small(DRIVE.twin(), DRIVE.recordings({}, (multisine, triangle)))
    with closing(case.simulations):
        stated = comparison_of(case, ABSENT)
        ledger = stated.search.opened(stated.first)
        base, problem = ledger.rows[frozenset()], stated.search.problem

        def that_gain() -> int:
            found = responses(problem, base, stated.search.elements)
            return sum(m.gain > LEAST_GAIN for m in ranked(ledger.whitening, base, found))

        beside = that_gain()
        monkeypatch.setattr(Fitted, "aside", lambda self: self)
        assert beside < 0.5 * that_gain(), "nothing is missing, and each looked like a gain"
