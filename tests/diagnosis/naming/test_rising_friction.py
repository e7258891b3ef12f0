"""Stribeck friction that nearly vanishes at low speed is no evidence of Stribeck friction."""

from __future__ import annotations

from dataclasses import replace

import pytest

from gmfbo.diagnosis.naming.candidate_fits import confirm
from gmfbo.diagnosis.screening.testable_effects import candidates
from tests.diagnosis.short_recordings import SERVO, moves, multisine, open_small, triangle

pytestmark = pytest.mark.slow

QUIET = replace(SERVO, noise={"position": 2e-6, "torque_command": 0.002})
LEVEL = 0.01


def shares_at_rest(share: float) -> list[float]:
    """Fitted breakaway over sliding level of the law that was hidden with this share."""
    hidden = {
        "stribeck_friction.level": LEVEL,
        "stribeck_friction.breakaway": share * LEVEL,
        "stribeck_friction.velocity": 0.5,
    }
    recordings = QUIET.recordings(hidden, (multisine, moves, triangle), seconds=2.0)
    case = open_small(QUIET.twin(), recordings)
    with case.simulations:
        start = candidates(["stribeck_friction"], case.setting.excitation)[0]
        fits = confirm(case.misfit, case.base, [start])
    values = [f.hypothesis.effects[0].values for f in fits]
    return [v["breakaway"] / v["level"] for v in values]


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.7, 1.8])
def test_what_is_friction_at_low_speed_too_is_fitted(share: float) -> None:
    assert shares_at_rest(share) == [pytest.approx(share, rel=0.15)]


def test_what_nearly_vanishes_at_low_speed_is_dropped() -> None:
    assert shares_at_rest(0.05) == []
