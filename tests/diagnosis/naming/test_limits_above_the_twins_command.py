"""A limit above what the nominal twin asks for is cut from what the real axis asks for."""

from __future__ import annotations

from contextlib import closing

import pytest

from tests.diagnosis.short_recordings import SERVO, decided, open_small

LIMIT = 1.4  # [N.m] above the peak of the twin's command, 1.38 N.m
FRICTION = 0.3  # [N.m] for which the controller asks on top


@pytest.mark.slow
def test_a_limit_that_only_friction_makes_the_command_reach_is_named() -> None:
    physics = {"actuator_saturation.limit": LIMIT, "coulomb_friction.level": FRICTION}
    recordings = SERVO.recordings(physics)
    with closing((case := open_small(SERVO.twin(), recordings)).simulations):
        assert case.setting.excitation.command < LIMIT
        decision = decided(case, ("actuator_saturation", "coulomb_friction"))
    assert {entry.winner.name for entry in decision.rounds} == {
        "actuator_saturation",
        "coulomb_friction",
    }
    last = decision.rounds[-1].winner.fitted.hypothesis.effects
    values = {effect.effect: dict(effect.values) for effect in last}
    assert values["actuator_saturation"]["limit"] == pytest.approx(LIMIT, rel=0.01)
    assert values["coulomb_friction"]["level"] == pytest.approx(FRICTION, rel=0.05)
