"""The curve beside a named law is what acts at the port, whatever law is named."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.diagnosis.fitting.fit import Fitted, fit
from gmfbo.diagnosis.fitting.hypothesis import Candidate, Hypothesis
from gmfbo.diagnosis.outside.named_law import inferred_beside_law
from gmfbo.diagnosis.outside.state_features import hats, hinges
from gmfbo.diagnosis.result.whereabouts import Shape
from gmfbo.physics import CATALOGUE, Units
from tests.diagnosis.port_cases import PortCase, open_servo, port_case

LEVEL = 0.05


@given(st.lists(st.floats(-5.0, 5.0), min_size=1, max_size=30))
def test_hats_add_up_to_one_everywhere(values: list[float]) -> None:
    knots = np.array([-2.0, -0.5, 0.0, 1.0, 3.0])
    np.testing.assert_allclose(hats(np.array(values), knots).sum(axis=0), 1.0)


def test_hinges_without_bends_are_straight_lines() -> None:
    knots = np.array([0.0, 1.0, 4.0, 6.0])
    turn = hinges(knots)
    np.testing.assert_allclose(turn @ [2.0, 3.0, 0.0, 0.0], 2.0 + 3.0 * knots / 6.0)
    assert abs(np.linalg.det(turn)) > 0.0


@pytest.fixture(scope="module")
def rubbing() -> Iterator[PortCase]:
    case = open_servo({"coulomb_friction.level": LEVEL})
    yield port_case(case)
    case.simulations.close()


def fitted(hidden: PortCase, effect: str) -> Fitted:
    case = hidden.case
    (start, *_) = CATALOGUE[effect].starts(case.setting.excitation)
    hypothesis = Hypothesis(case.setting, (Candidate(effect, start),))
    found = fit(case.misfit, hypothesis, case.base.parameters)
    assert found is not None
    return found


def shape_of(hidden: PortCase, effect: str) -> Shape:
    found = inferred_beside_law(hidden.case, fitted(hidden, effect), hidden.response, Units())
    assert found is not None
    assert found.law == effect
    return found


def law_at(shape: Shape, x: np.ndarray) -> np.ndarray:
    return np.asarray(np.interp(x, shape.law_x, shape.law_y))


def test_the_right_law_lies_within_the_band_of_the_curve(rubbing: PortCase) -> None:
    shape = shape_of(rubbing, "coulomb_friction")
    x = np.array(shape.x)
    moving = np.abs(x) > 0.05 * np.abs(x).max()  # beside standstill a jump has no one value
    truth = -LEVEL * np.sign(x)
    np.testing.assert_allclose(np.array(shape.y)[moving], truth[moving], atol=0.04 * LEVEL)
    np.testing.assert_allclose(law_at(shape, x)[moving], truth[moving], rtol=0.02)
    inside = (np.array(shape.y_low) <= truth) & (truth <= np.array(shape.y_high))
    assert np.mean(inside[moving]) >= 0.8


def test_control_a_wrong_law_is_seen_to_be_wrong(rubbing: PortCase) -> None:
    """The curve shows what acts, not what was named."""
    shape = shape_of(rubbing, "quadratic_drag")
    x = np.array(shape.x)
    apart = np.abs(law_at(shape, x) - np.array(shape.y))
    assert apart.max() > 0.3 * LEVEL
    inside = (np.array(shape.y_low) <= law_at(shape, x)) & (law_at(shape, x) <= shape.y_high)
    assert np.mean(inside) < 0.5


def test_without_a_law_at_the_torque_port_there_is_no_curve(rubbing: PortCase) -> None:
    case = rubbing.case
    assert inferred_beside_law(case, case.base, rubbing.response, Units()) is None
    assert inferred_beside_law(case, fitted(rubbing, "coulomb_friction"), None, Units()) is None
