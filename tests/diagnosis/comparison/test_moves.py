"""Where an element of the search begins."""

from __future__ import annotations

import pytest

from gmfbo.diagnosis.comparison.moves import Element
from gmfbo.sources.twin.uncertain import Uncertain


@pytest.mark.parametrize(
    ("share", "expected"), [(1.0, 2.3), (-0.4, 1.88), (1.6, 2.48), (-20.0, 0.5)]
)
def test_a_freed_parameter_begins_where_a_straight_line_has_it_best(
    share: float, expected: float
) -> None:
    element = Element(freed=Uncertain("filter_time", 2.0, 0.5, 8.0))
    # A fit begins at the whole of the start that a ranking has moved.
    begun = element.moved(share, {}).moved(1.0, {}).start({"inertia": 1.0})
    assert begun == {"inertia": 1.0, "filter_time": pytest.approx(expected)}
