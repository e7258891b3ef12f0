"""Where an element of the search begins."""

from __future__ import annotations

from dataclasses import replace

import pytest

from gmfbo.diagnosis.comparison.moves import Element
from gmfbo.diagnosis.fitting.hypothesis import Candidate, Hypothesis, Setting
from gmfbo.sources.twin.uncertain import Uncertain
from tests.physics.excitations import TYPICAL


@pytest.mark.parametrize(
    ("share", "expected"), [(1.0, 2.3), (-0.4, 1.88), (1.6, 2.48), (-20.0, 0.5)]
)
def test_a_freed_parameter_begins_where_a_straight_line_has_it_best(
    share: float, expected: float
) -> None:
    element = Element(freed=Uncertain("filter_time", 2.0, 0.5, 8.0))
    # A fit begins at the whole of the start that a ranking has moved.
    twin = Hypothesis(Setting((), TYPICAL))
    begun = element.moved(share, {}, twin).moved(1.0, {}, twin).start({"inertia": 1.0})
    assert begun == {"inertia": 1.0, "filter_time": pytest.approx(expected)}


def test_less_of_a_limit_is_a_limit_nearer_to_what_the_motion_asks_for() -> None:
    met = ((0.0, 6.0), (8.0, 5.0), (10.0, 1.0))  # |velocity|, |command|
    twin = Hypothesis(Setting((), replace(TYPICAL, demands=met)))
    limit = Element(Candidate("supply_voltage_limit", {"limit": 8.0, "slope": 0.5}))
    assert limit.can_shrink(twin)
    tenth = limit.moved(0.1, {}, twin).candidate
    # At 8 velocities and 5 commands, 9 are asked for.
    assert tenth is not None
    assert tenth.values == {"limit": pytest.approx(9.0 - 0.1 * 1.0), "slope": 0.5}
