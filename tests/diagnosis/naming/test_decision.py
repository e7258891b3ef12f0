"""Nothing is named where nothing is missing, or where a motion hides what could have been."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import pytest

from gmfbo.diagnosis.comparison.numbers import DOUBTED, MOST_SAID
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
    assert decision.untestable == {"viscous_friction": "is parameter viscous"}


def test_coulomb_friction_is_named_at_its_level_and_not_once_more_by_a_larger_law() -> None:
    """Nor do effects that the motion does not excite, and that explain less, cast doubt on it."""
    silent = ["constant_torque_offset", "sensor_lag"]
    decision = decision_on(FRICTION, names=("stribeck_friction", "hysteresis", *FEW), silent=silent)
    assert winners(decision) == ["coulomb_friction"]
    (found,) = decision.rounds
    assert found.winner.effect.values["level"] == pytest.approx(0.25, rel=0.02)
    assert found.gain > 100.0 * decision.threshold
    assert found.probability == MOST_SAID < worth(found.belief, found.gain)
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


def one_way(physics: Mapping[str, float], begins: float) -> Decision:
    """What is decided on two ramps from rest, of which the first seconds may not be compared."""
    recordings = [
        replace(own, use=(begins, float(own.time[-1])))
        for own in SERVO.recordings(physics, (climb, climb), seed=5)
    ]
    case = open_small(SERVO.twin(), recordings)
    silent = ["coulomb_friction", "constant_torque_offset"]
    testable = ["transport_delay", "elastic_return"]
    try:
        return decide(case, testable, (), lambda stage, share: None, silent=silent)
    finally:
        case.simulations.close()


@pytest.mark.parametrize(
    ("physics", "named"),
    [
        (FRICTION, "coulomb_friction"),
        pytest.param(
            {"constant_torque_offset.level": -0.25},
            "constant_torque_offset",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_a_start_from_rest_tells_friction_from_a_constant_torque(
    physics: Mapping[str, float], named: str
) -> None:
    """Friction holds until the axis moves; without a reversal it is no fact all the same."""
    decision = one_way(physics, 0.0)
    (found,) = decision.rounds
    assert found.names == (named,)
    level = found.winner.effect.values["level"]
    assert abs(level) == pytest.approx(0.25, rel=0.02)
    assert found.probability <= DOUBTED
    (note,) = decision.notes
    assert note.startswith("no recording reverses")


@pytest.mark.parametrize(
    "physics",
    [FRICTION, pytest.param({"constant_torque_offset.level": -0.25}, marks=pytest.mark.slow)],
)
def test_friction_and_a_constant_torque_are_one_set_while_an_axis_moves_one_way(
    physics: Mapping[str, float],
) -> None:
    (found,) = one_way(physics, 0.4).rounds
    assert set(found.names) == {"coulomb_friction", "constant_torque_offset"}
    first, second = (share.probability for share in found.shares)
    assert first == pytest.approx(second, rel=0.3)
    assert first + second == pytest.approx(found.probability)
    assert found.probability <= DOUBTED


@pytest.mark.slow
def test_what_a_one_way_motion_shows_is_named_beside_friction() -> None:
    """A load that turns with the shaft shows over the position, whatever else holds it back."""
    names = ("coulomb_friction", "gravity_torque")
    hidden = {**FRICTION, "gravity_torque.sine": -0.3}
    decision = decision_on(hidden, (climb,), names=names, silent=["coulomb_friction"])
    told = {found.winner.name: found.probability for found in decision.rounds}
    assert told.keys() == {"coulomb_friction", "gravity_torque"}
    assert told["coulomb_friction"] <= DOUBTED
