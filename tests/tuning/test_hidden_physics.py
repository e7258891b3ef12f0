"""Physics of a plant that is drawn from the study's seed."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from gmfbo.tuning.study_file.study_sections import HiddenPhysics

GROUPS: dict[str, dict[str, tuple[float, float]]] = {
    "friction": {"friction.coulomb": (1.0, 6.0), "friction.stribeck": (0.2, 2.0)},
    "backlash": {"gear.backlash": (2e-3, 2e-2)},
    "delay": {"ctl.delay": (4, 10)},
}


@given(st.integers(0, 10_000))
def test_one_or_two_groups_are_drawn_within_their_ranges(seed: int) -> None:
    hidden = HiddenPhysics(count=(1, 2), groups=GROUPS)
    drawn = hidden.drawn(seed)
    chosen = [group for group, names in GROUPS.items() if set(names) <= set(drawn)]
    assert 1 <= len(chosen) <= 2
    assert set(drawn) == {name for group in chosen for name in GROUPS[group]}
    for group in chosen:
        for name, (low, high) in GROUPS[group].items():
            assert low <= drawn[name] <= high
    assert float(drawn.get("ctl.delay", 4.0)).is_integer()


def test_a_seed_draws_the_same_again_and_another_seed_something_else() -> None:
    hidden = HiddenPhysics(count=(1, 2), groups=GROUPS)
    assert hidden.drawn(7) == hidden.drawn(7)
    assert len({tuple(hidden.drawn(seed).items()) for seed in range(20)}) > 15


def test_each_group_comes_up() -> None:
    # With 60 draws of one in three a group is left out with a probability of 3e-11.
    hidden = HiddenPhysics(groups=GROUPS)
    assert {len(hidden.drawn(seed)) for seed in range(60)} == {1, 2}
    assert {name for seed in range(60) for name in hidden.drawn(seed)} == {
        name for names in GROUPS.values() for name in names
    }


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"count": (1, 4)}, r"count: expected \[least, most\] of the 3 groups, got \[1, 4\]"),
        (
            {"groups": {"gap": {"gear.backlash": (0.0, 1.0)}}},
            r"groups\.gap 'gear\.backlash': expected \[low, high\] with 0 < low <= high",
        ),
    ],
)
def test_what_cannot_be_drawn_is_refused(fields: dict[str, object], message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        HiddenPhysics.model_validate({"groups": GROUPS, **fields})
