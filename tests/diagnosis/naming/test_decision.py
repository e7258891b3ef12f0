"""Nothing is named where nothing is missing, or where a motion hides what could have been."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import pytest

from gmfbo.diagnosis.comparison.numbers import MOST_SAID
from gmfbo.diagnosis.naming.decided_by_score import decide
from gmfbo.diagnosis.naming.decision import Decision
from gmfbo.diagnosis.naming.worth import worth
from gmfbo.physics import CATALOGUE
from tests.diagnosis.short_recordings import SERVO, Reference, climb, moves, multisine, open_small

FRICTION = {"coulomb_friction.level": 0.25, "coulomb_friction.deflection": 1e-6}
LAWS = {name for name, effect in CATALOGUE.items() if "coulomb_friction" in effect.contains}
FEW = (
    "coulomb_friction",
    "viscous_friction",
    "constant_torque_offset",
    "transport_delay",
    "sensor_lag",
)


def decision_on(
    physics: Mapping[str, float],
    references: Sequence[Reference] = (multisine, moves),
    *,
    names: Collection[str] = FEW,
    silent: Collection[str] = (),
    seed: int = 5,
) -> Decision:
    """Decide on short recordings whether some effects are missing, parts of them unheard."""
    case = open_small(SERVO.twin(), SERVO.recordings(physics, references, seed=seed))
    try:
        testable = [name for name in names if name not in silent]
        return decide(case, testable, (), lambda stage, share: None, silent=silent)
    finally:
        case.simulations.close()


def winners(decision: Decision) -> list[str]:
    return [found.winner.name for found in decision.rounds]


@pytest.mark.parametrize(
    "seed", [5, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (6, 7))]
)
def test_where_nothing_is_missing_nothing_is_named(seed: int) -> None:
    decision = decision_on({}, seed=seed)
    assert decision.rounds == ()
    assert decision.freed == {}
    assert decision.notes == ()
    assert decision.model.hypothesis.effects == ()
    assert decision.like_parameters == {"viscous_friction": "is parameter viscous"}


def test_coulomb_friction_is_named_at_its_level_and_not_once_more_by_a_larger_law() -> None:
    """Nor do effects that the motion does not excite, and that explain less, cast doubt on it."""
    silent = ["constant_torque_offset", "sensor_lag"]
    decision = decision_on(FRICTION, names=("stribeck_friction", "hysteresis", *FEW), silent=silent)
    assert winners(decision) == ["coulomb_friction"]
    (found,) = decision.rounds
    assert found.winner.effect.values["level"] == pytest.approx(0.25, rel=0.02)
    assert found.gain > 100.0 * decision.threshold
    assert found.probability == MOST_SAID < worth(found.belief, found.gain, fell=True)
    assert not {rival.name for rival in found.rivals} & LAWS
    assert decision.notes == ()


def test_a_transport_delay_is_named_at_its_time() -> None:
    decision = decision_on({"transport_delay.delay": 2e-3})
    assert winners(decision) == ["transport_delay"]
    delay = decision.rounds[0].winner.effect.values["delay"]
    assert delay == pytest.approx(2e-3, abs=1.5e-4)


@pytest.mark.slow
def test_friction_and_a_delay_are_named_one_after_the_other_the_stronger_first() -> None:
    decision = decision_on({**FRICTION, "transport_delay.delay": 2e-3})
    assert winners(decision) == ["coulomb_friction", "transport_delay"]
    assert decision.rounds[0].gain > decision.rounds[1].gain


@pytest.mark.parametrize(
    "claimable", [("constant_torque_offset",), pytest.param((), marks=pytest.mark.slow)]
)
def test_friction_on_a_ramp_one_way_is_not_named(claimable: tuple[str, ...]) -> None:
    """A constant torque would do the same there: to name it would be a guess."""
    names = ("coulomb_friction", "transport_delay", *claimable)
    decision = decision_on(FRICTION, (climb, climb), names=names, silent=["coulomb_friction"])
    assert any("no reversal" in note for note in decision.notes)
    assert decision.rounds == ()
    assert decision.model.hypothesis.effects == ()


def test_what_a_one_way_motion_shows_is_named_beside_friction_that_it_does_not() -> None:
    """A load that turns with the shaft shows over the position, whatever else holds it back."""
    names = ("coulomb_friction", "gravity_torque")
    hidden = {**FRICTION, "gravity_torque.sine": -0.3}
    decision = decision_on(hidden, (climb,), names=names, silent=["coulomb_friction"])
    assert any("no reversal" in note for note in decision.notes)
    assert winners(decision) == ["gravity_torque"]
