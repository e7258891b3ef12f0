"""The unnamed model finds the state and the shape of torques that were hidden."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from gmfbo.diagnosis.fitting.fit import fit
from gmfbo.diagnosis.fitting.hypothesis import Candidate, Hypothesis
from gmfbo.diagnosis.outside.free_function import Unnamed, unnamed
from gmfbo.diagnosis.outside.state_features import hats, hinges
from gmfbo.diagnosis.result.whereabouts import Shape
from tests.diagnosis.port_cases import PortCase, open_servo, port_case

Array = NDArray[np.float64]
UNITS = {"torque": "N.m", "position": "rad", "velocity": "rad/s"}


@pytest.fixture
def servo(right_servo: PortCase) -> PortCase:
    return right_servo


@pytest.fixture(scope="module")
def friction() -> Iterator[PortCase]:
    case = open_servo({"coulomb_friction.level": 0.05})
    yield port_case(case)
    case.simulations.close()


def root_friction(velocity: Array, position: Array) -> Array:
    """Grows with the root of the speed, as no law of the catalogue does."""
    return np.asarray(-0.04 * velocity / (velocity**2 + 0.05**2) ** 0.25)


def stiffening_spring(velocity: Array, position: Array) -> Array:
    """Grows with the cube of the position."""
    return np.asarray(-0.2 * (position - 0.1) ** 3)


def searched(hidden: PortCase) -> Unnamed:
    return unnamed(hidden.case, hidden.case.base, hidden.response)


def covered(shape: Shape, truth: Array) -> float:
    """Share of the knots at which the band holds the truth; a hundredth of it is no difference."""
    slack = 0.02 * float(np.abs(truth).max())
    low, high = np.array(shape.y_low) - slack, np.array(shape.y_high) + slack
    return float(np.mean((truth >= low) & (truth <= high)))


def up_to_a_slope(shape: Shape, truth: Array) -> Array:
    """Truth turned by the slope that the twin's own viscous friction explains as well."""
    x, y = np.array(shape.x), np.array(shape.y)
    weight = 1.0 / (np.array(shape.y_high) - np.array(shape.y_low)) ** 2
    slope = float(np.sum(weight * x * (y - truth)) / np.sum(weight * x**2))
    return np.asarray(truth + slope * x)


@pytest.mark.slow
def test_friction_of_no_known_law_is_a_function_of_the_velocity() -> None:
    hidden = port_case(open_servo({}, law=root_friction))
    found = searched(hidden)
    hidden.case.simulations.close()
    shape = found.shape(UNITS)
    assert found.best.family.name == "velocity"
    assert found.best.gain > 1000.0
    assert (shape.port, shape.against, shape.unit_x, shape.unit_y) == (
        "torque",
        "velocity",
        "rad/s",
        "N.m",
    )
    truth = up_to_a_slope(shape, root_friction(np.array(shape.x), np.zeros(1)))
    assert covered(shape, truth) >= 0.85


@pytest.mark.slow
def test_a_stiffening_spring_is_a_function_of_the_position() -> None:
    hidden = port_case(open_servo({}, law=stiffening_spring))
    found = searched(hidden)
    hidden.case.simulations.close()
    shape = found.shape(UNITS)
    assert found.best.family.name == "position"
    assert covered(shape, stiffening_spring(np.zeros(1), np.array(shape.x))) >= 0.8


@pytest.mark.slow
def test_friction_that_depends_on_the_place_has_the_sign_of_the_velocity() -> None:
    physics = {"level": 0.08, "sine": 0.04, "wavenumber": 5.0}
    case = open_servo({f"position_dependent_friction.{n}": v for n, v in physics.items()})
    found = searched(port_case(case))
    case.simulations.close()
    shape = found.shape(UNITS)
    assert found.best.family.name == "signed_position"
    assert shape.against == "position, with the sign of the velocity"
    truth = -0.08 - 0.04 * np.sin(5.0 * np.array(shape.x))
    # The outermost knots, where the axis hardly comes, may be further off than the band says.
    np.testing.assert_allclose(shape.y[1:-1], truth[1:-1], atol=0.012)


def test_what_happens_in_one_recording_is_a_function_of_its_time(servo: PortCase) -> None:
    torques = [np.zeros(rows) for rows in servo.response.rows]
    torques[2] = 0.05 * np.sin(2.0 * np.pi * 1.1 * servo.states[2].time)
    base = servo.with_torque(torques, seed=1)
    found = unnamed(servo.case, base, servo.response)
    shape = found.shape(UNITS)
    assert found.best.family.name == "time"
    assert int(np.argmax(found.best.gains)) == 2
    assert shape.unit_x == "s"
    # Knots at 0.18 s cut the crests of a wave of 0.9 s by up to a tenth.
    truth = 0.05 * np.sin(2.0 * np.pi * 1.1 * np.array(shape.x))
    np.testing.assert_allclose(shape.y[1:-1], truth[1:-1], atol=0.012)


def test_white_residuals_gain_nothing(servo: PortCase) -> None:
    """Of 20 nulls none gains above 15; one in a hundred may."""
    gains = [unnamed(servo.case, servo.white(seed), servo.response).best.gain for seed in range(20)]
    assert max(gains) < 15.0


def test_nothing_is_left_behind_the_right_named_effect(friction: PortCase) -> None:
    case = friction.case
    before = searched(friction).best.gain
    named = Candidate("coulomb_friction", {"level": 0.04})
    found = fit(case.misfit, Hypothesis(case.setting, (named,)), case.base.parameters)
    assert found is not None
    after = unnamed(case, found, friction.response).best.gain
    assert before > 1000.0
    assert after < 0.01 * before


def test_friction_alone_keeps_its_sign_and_size(friction: PortCase) -> None:
    found = searched(friction)
    signed = found.shape(UNITS, "signed_position")
    np.testing.assert_allclose(signed.y[1:8], -0.05, atol=0.003)
    # The ends of the way rest on few rows, and lean towards nothing.
    assert np.all(np.array(signed.y[:-1]) < -0.035)
    assert found.of("velocity").gain > 0.9 * found.best.gain


def test_recordings_left_out_are_predicted(friction: PortCase) -> None:
    case, found = friction.case, searched(friction)
    for k in range(len(case.simulations.records)):
        rest: list[tuple[Array, ...]] = [(0.0 * s.time, 0.0 * s.time) for s in friction.states]
        rest[k] = found.predicted(k, without=[k])
        blocks = case.misfit.whitened(rest)
        own = [w.window.record == k for w in case.misfit.whiteners]
        pairs = zip(case.base.residual, blocks, own, strict=True)
        squares = [(np.sum(r**2), np.sum((r - b) ** 2)) for r, b, mine in pairs if mine]
        before, after = np.sum(squares, axis=0)
        assert after < 0.6 * before


def test_a_prediction_of_all_recordings_is_the_regression_itself(friction: PortCase) -> None:
    case, found = friction.case, searched(friction)
    changes = [found.predicted(k) for k in range(len(case.simulations.records))]
    blocks = case.misfit.whitened(changes)
    left = sum(float(np.sum((r - b) ** 2)) for r, b in zip(case.base.residual, blocks, strict=True))
    assert case.base.chi2 - left == pytest.approx(found.best.fall, rel=0.01)


def test_gains_of_recordings_add_up(friction: PortCase) -> None:
    for fitted in searched(friction).families:
        assert len(fitted.gains) == len(friction.case.simulations.records)
        assert sum(fitted.gains) == pytest.approx(fitted.gain)


@given(st.lists(st.floats(-5.0, 5.0), min_size=1, max_size=30))
def test_hats_add_up_to_one_everywhere(values: list[float]) -> None:
    knots = np.array([-2.0, -0.5, 0.0, 1.0, 3.0])
    np.testing.assert_allclose(hats(np.array(values), knots).sum(axis=0), 1.0)


def test_hinges_without_bends_are_straight_lines() -> None:
    knots = np.array([0.0, 1.0, 4.0, 6.0])
    turn = hinges(knots)
    np.testing.assert_allclose(turn @ [2.0, 3.0, 0.0, 0.0], 2.0 + 3.0 * knots / 6.0)
    assert abs(np.linalg.det(turn)) > 0.0
