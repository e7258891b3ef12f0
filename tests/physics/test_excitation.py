"""What recordings show is refused where nothing can be scaled by it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from gmfbo.errors import InputError
from tests.physics.excitations import TYPICAL


@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf")])
def test_a_range_must_be_positive(value: float) -> None:
    with pytest.raises(InputError, match="a speed above zero"):
        replace(TYPICAL, speed=value)


def test_an_inertia_must_be_positive_where_it_is_known() -> None:
    with pytest.raises(InputError, match="an inertia above zero, got 0"):
        replace(TYPICAL, inertia=0.0)


def test_an_unknown_inertia_is_what_the_torque_moves_in_a_loop_time() -> None:
    unknown = replace(TYPICAL, inertia=None)
    assert unknown.shaft_inertia == pytest.approx(9.0 * 0.03 / 10.0)
    assert TYPICAL.shaft_inertia == 0.12


def test_the_current_stands_for_an_unknown_load() -> None:
    assert TYPICAL.load_range == TYPICAL.current
    assert replace(TYPICAL, load=2.0).load_range == 2.0


@pytest.mark.parametrize(("slope", "asked"), [(0.0, 6.0), (0.5, 9.0), (2.0, 21.0)])
def test_the_largest_demand_of_a_motion_is_that_of_one_instant(slope: float, asked: float) -> None:
    met = ((0.0, 6.0), (8.0, 5.0), (10.0, 1.0))  # |velocity|, |command|
    assert replace(TYPICAL, demands=met).largest_demand(slope) == asked


def test_without_a_motion_its_ranges_are_met_together() -> None:
    assert TYPICAL.largest_demand(0.5) == TYPICAL.command + 0.5 * TYPICAL.speed
