"""A torque that no effect of the library makes is told from one that the library holds."""

from __future__ import annotations

from collections.abc import Mapping
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.naming import withdrawn_names
from gmfbo.diagnosis.naming.decision import Decision
from gmfbo.diagnosis.outside.beyond_library import Outside, look_outside
from tests.diagnosis.port_cases import Law, open_servo, port_case
from tests.diagnosis.short_recordings import decided

Array = NDArray[np.float64]

LIBRARY = ("coulomb_friction", "gravity_torque", "elastic_return", "transport_delay")


def dead_band_spring(velocity: Array, position: Array) -> Array:
    """Nothing within 0.15 rad of the middle, 1 N m per rad beyond."""
    return np.asarray(np.clip(position, -0.15, 0.15) - position)


def drag_that_grows_along_the_way(velocity: Array, position: Array) -> Array:
    """Viscous, with a coefficient in proportion to the position, which drives on one side."""
    return np.asarray(-0.1 * position * velocity)


def spring_of_wide_strokes(velocity: Array, position: Array) -> Array:
    """Nothing within 0.3 rad of the middle, which one of three recordings leaves by far."""
    return np.asarray(0.3 * (np.clip(position, -0.3, 0.3) - position))


def late_on_one_side(velocity: Array, position: Array) -> Array:
    """A reading that comes late by a millisecond for each radian, and early on the other side."""
    return np.asarray(-1e-3 * position * velocity)


def tight_spot_one_way(velocity: Array, position: Array) -> Array:
    """Coulomb friction, five times as much on one half of the way while going forth."""
    spot = 1.0 + 4.0 * (position > 0.0) * (velocity > 0.0)
    return np.asarray(-0.003 * spot * np.tanh(velocity / 1e-2))


def looked(
    physics: Mapping[str, float], law: Law | None = None, port: str = "torque"
) -> tuple[Decision, Outside]:
    """Decide on a servo axis with something hidden at a port, and look outside the library."""
    hidden = port_case(open_servo(physics, law=law, port=port))
    try:
        case, decision = hidden.case, decided(hidden.case, LIBRARY)
        before = case.misfit, case.base, decision.model
        found = look_outside(case, decision, hidden.response, np.random.default_rng(0))
        # The case is measured by the budget alone only while it is looked at.
        assert (case.misfit, case.base, decision.model) == before
        return decision, found
    finally:
        hidden.case.simulations.close()


@pytest.mark.parametrize(
    ("law", "family"),
    [
        pytest.param(dead_band_spring, "position", marks=pytest.mark.slow),
        (drag_that_grows_along_the_way, "damped_position"),
    ],
)
def test_a_law_that_no_effect_makes_is_outside_the_library(law: Law, family: str) -> None:
    decision, outside = looked({}, law)
    assert outside.is_better
    assert outside.model.best.family.name == family
    assert outside.gain > 1000.0 * decision.threshold
    assert outside.named < 0.7 * outside.gain


def test_what_a_sensor_does_is_found_at_its_port() -> None:
    decision, outside = looked({}, late_on_one_side, "sensor")
    assert decision.rounds == []
    assert outside.is_better
    shape = outside.model.shape({"sensor": "rad"})
    assert (shape.port, shape.unit_y) == ("sensor", "rad")


@pytest.mark.slow
def test_friction_of_the_library_is_not_outside_it() -> None:
    """Negative control: the free function explains as much as the name, and loses to it."""
    decision, outside = looked({"coulomb_friction.level": 0.1})
    assert [found.winner.name for found in decision.rounds] == ["coulomb_friction"]
    assert not outside.is_better
    assert outside.named > 0.95 * outside.gain > 1000.0


@pytest.mark.slow
def test_where_nothing_is_missing_nothing_is_outside_the_library() -> None:
    decision, outside = looked({})
    assert decision.rounds == []
    assert outside.named == 0.0
    assert not outside.is_better
    assert outside.gain < decision.threshold


@pytest.mark.slow
def test_friction_that_differs_by_place_in_one_direction_is_seen_beside_a_name() -> None:
    decision, outside = looked({}, tight_spot_one_way)
    assert [found.winner.name for found in decision.rounds] == ["coulomb_friction"]
    assert outside.is_better


@pytest.mark.slow
def test_a_spring_against_which_recordings_speak_is_disputed() -> None:
    decision, outside = looked({}, spring_of_wide_strokes)
    assert decision.rounds == []
    assert decision.disputed is not None
    assert decision.disputed.name == "elastic_return"
    assert outside.is_better


@pytest.mark.parametrize("is_more", [True, False])
def test_what_is_disputed_is_said_where_something_is_missing(
    is_more: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    spring = SimpleNamespace(name="elastic_return")
    decision = Decision(disputed=spring)  # type: ignore[arg-type]
    case = SimpleNamespace(notes=[], base=None)
    monkeypatch.setattr(withdrawn_names, "is_more_than_noise", lambda case, model: is_more)
    withdrawn_names.note_what_is_not_named(case, decision)  # type: ignore[arg-type]
    assert len(case.notes) == is_more
    assert all("some of them speak against it" in note for note in case.notes)


@pytest.mark.slow
def test_a_spring_of_the_library_is_not_disputed() -> None:
    decision, _ = looked({"elastic_return.stiffness": 0.3})
    assert [found.winner.name for found in decision.rounds] == ["elastic_return"]
    assert decision.disputed is None
