"""How far a run may move: a factor of two, a tenth of the box, or one step of a gain of steps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.space import Gain, GainSpace
from gmfbo.tuning.history.move_limit import MoveLimit

SPACE = GainSpace(
    (
        Gain("linear", 0.0, 200.0),
        Gain("log", 1e-3, 1e3, "log"),
        Gain("whole", 0.0, 50.0, integer=True),
        Gain("listed", 1.0, 100.0, values=(1.0, 10.0, 100.0)),
    )
)


def ends(values: list[float]) -> tuple[np.ndarray, np.ndarray]:
    limit = MoveLimit.around(SPACE, SPACE.to_unit([values]))
    return limit.low[0], limit.high[0]


def test_a_gain_moves_by_the_larger_of_factor_and_share() -> None:
    low, high = ends([80.0, 1.0, 0.0, 10.0])
    assert SPACE.from_unit(low)[:2] == pytest.approx([40.0, 10**-0.6])
    assert SPACE.from_unit(high)[:2] == pytest.approx([160.0, 10**0.6])
    low, high = ends([5.0, 1.0, 0.0, 10.0])
    assert SPACE.from_unit(high)[0] == pytest.approx(25.0)


def test_a_gain_of_steps_reaches_its_neighbours() -> None:
    _, high = ends([80.0, 1.0, 0.0, 10.0])
    assert SPACE.from_unit(high)[2:] == pytest.approx([5.0, 100.0])


@given(st.lists(st.floats(0.0, 1.0), min_size=8, max_size=8))
def test_the_nearest_place_is_admitted_and_admitted_points_stay(numbers: list[float]) -> None:
    start, point = np.array(numbers).reshape(2, 1, 4)
    limit = MoveLimit.around(SPACE, SPACE.to_unit(SPACE.from_unit(start)))
    moved = limit.nearest(point)
    assert limit.admits(moved).all()
    assert limit.nearest(moved) == pytest.approx(moved)
    if limit.admits(point).all():
        assert moved == pytest.approx(point, abs=1e-8)
