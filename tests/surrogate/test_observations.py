"""Observations: what enters the surrogate, on which scale and with which sign."""

from __future__ import annotations

import numpy as np
import pytest

from gmfbo.errors import InputError
from gmfbo.surrogate.observations import Observations

ROWS = [([0.1, 0.2], "IS1", 3.0), ([0.3, 0.4], "IS2", -1.0), ([0.5, 0.6], "IS3", 2.0)]


def test_objective_keeps_its_sign_and_source_is_the_last_column() -> None:
    observations = Observations.gather(ROWS)
    assert observations.train_Y().flatten().tolist() == [3.0, -1.0, 2.0]
    assert observations.train_X()[:, -1].tolist() == [1.0, 0.0, 0.5]
    assert observations.train_X()[:, :2].tolist() == [[0.1, 0.2], [0.3, 0.4], [0.5, 0.6]]


def test_standardised_values_have_zero_mean_and_unit_deviation_and_come_back() -> None:
    observations = Observations.gather(ROWS)
    transform = observations.outcome_transform()
    standard, _ = transform(observations.train_Y())
    assert standard.mean().item() == pytest.approx(0.0, abs=1e-15)
    assert standard.std().item() == pytest.approx(1.0, rel=1e-14)
    back, _ = transform.untransform(standard)
    np.testing.assert_allclose(back.flatten(), [3.0, -1.0, 2.0], rtol=1e-15)


def test_incumbent_is_the_least_value_of_its_own_source() -> None:
    observations = Observations.gather([*ROWS, ([0.9, 0.9], "IS1", 1.5)])
    assert observations.incumbent("IS1") == 1.5
    assert observations.incumbent("IS2") == -1.0
    assert Observations.gather(ROWS[:1]).incumbent("IS2") is None


def test_arrays_cannot_be_changed_afterwards() -> None:
    points = np.array([[0.5]])
    observations = Observations(points, ("IS1",), np.array([1.0]))
    points[0, 0] = 0.0
    assert observations.points[0, 0] == 0.5
    with pytest.raises(ValueError, match="read-only"):
        observations.values[0] = 2.0


@pytest.mark.parametrize(
    ("points", "sources", "values", "message"),
    [
        ([[1.5]], ("IS1",), [0.0], "unit cube"),
        ([[0.5]], ("IS4",), [0.0], "no information source 'IS4'; did you mean 'IS"),
        ([[0.5]], ("IS1",), [np.nan], "price a failed run"),
        ([[0.5]], ("IS1", "IS2"), [0.0], "one a point"),
        (np.empty((0, 2)), (), [], "n > 0"),
    ],
)
def test_bad_observations_are_refused(
    points: list[list[float]], sources: tuple[str, ...], values: list[float], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        Observations(np.array(points), sources, np.array(values))
