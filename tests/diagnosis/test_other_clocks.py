"""A diagnosis does not depend on when the logger's clock began; it tells times by that clock."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gmfbo import diagnose
from tests.diagnosis.short_recordings import SERVO, multisine, triangle

LATER = 5000.0  # [s]
PULSE = {"start": 0.5, "duration": 0.1, "level": 1.5}


@pytest.mark.slow
def test_a_pulse_is_named_on_any_clock_and_found_at_its_own_time() -> None:
    physics = {f"pulse_disturbance.{name}": value for name, value in PULSE.items()}
    recorded = SERVO.recordings(physics, (multisine, triangle))
    later = [replace(one, time=one.time + LATER) for one in recorded]
    first, second = (diagnose(SERVO.twin(), given, jobs=1) for given in (recorded, later))
    assert [effect.name for effect in first.effects] == ["pulse_disturbance"]
    assert second.sentence == first.sentence
    assert first.location.times
    for one, other in zip(first.location.times, second.location.times, strict=True):
        assert other.start - LATER == pytest.approx(one.start, abs=2e-3)
        assert other.end - LATER == pytest.approx(one.end, abs=2e-3)
    for curve, own in zip(first.curves, second.curves, strict=True):
        np.testing.assert_allclose(own.time - LATER, curve.time, atol=1e-6)
