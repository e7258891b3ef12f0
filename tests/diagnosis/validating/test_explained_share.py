"""Shares of a mismatch that laws explain, by their definition, and what may not be said."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.diagnosis.validating.explained_share import Squares
from gmfbo.diagnosis.validating.withdrawn import met_worse_with

NOISE = np.full(12, 200.0)


def squares(before: float, after: float, **without: float) -> Squares:
    """Twelve alike stretches, as multiples of what noise gives."""
    lost = {name: value * NOISE for name, value in without.items()}
    return Squares(NOISE, before * NOISE, after * NOISE, lost)


def test_a_share_is_what_is_gone_of_what_was_more_than_noise() -> None:
    found = squares(11.0, 3.0, coulomb_friction=11.0)
    share = found.share("coulomb_friction")
    assert share is not None
    assert (share.value, share.low, share.high) == pytest.approx((0.8, 0.8, 0.8))
    assert found.remainder == pytest.approx(0.2)


def test_what_is_removed_is_what_the_only_law_explains() -> None:
    found = squares(11.0, 3.0, coulomb_friction=11.0)
    assert found.removed == pytest.approx(0.8)
    assert squares(11.0, 0.9, coulomb_friction=11.0).removed == pytest.approx(1.0)
    assert squares(11.0, 13.0).removed == pytest.approx(-0.2)
    assert squares(1.0, 0.9).removed is None


def test_of_several_laws_each_has_its_own_loss() -> None:
    found = squares(11.0, 1.0, backlash=4.0, coulomb_friction=8.0)
    shares = {name: found.share(name) for name in ("backlash", "coulomb_friction")}
    values = {name: share.value for name, share in shares.items() if share}
    assert values == pytest.approx({"backlash": 0.3, "coulomb_friction": 0.7})


def test_where_only_noise_is_left_there_is_no_remainder() -> None:
    assert squares(11.0, 1.0, backlash=11.0).remainder is None


def test_where_there_is_nothing_to_explain_there_is_no_share() -> None:
    assert squares(1.0, 0.9, backlash=1.0).share("backlash") is None
    assert squares(11.0, 3.0).share("backlash") is None


@given(st.lists(st.floats(2.0, 40.0), min_size=8, max_size=20), st.floats(0.0, 1.0))
def test_the_interval_holds_the_share(before: list[float], explained: float) -> None:
    noise = np.full(len(before), 500.0)
    left = noise * (1.0 + (1.0 - explained) * (np.array(before) - 1.0))
    share = Squares(noise, noise * np.array(before), left, {"backlash": noise * before}).share(
        "backlash"
    )
    assert share is not None
    assert share.low - 1e-9 <= share.value <= share.high + 1e-9
    assert share.value == pytest.approx(explained, abs=1e-9)


@pytest.mark.parametrize(
    ("before", "after", "gain_nothing"),
    [(3.0, 3.0, True), (3.0, 4.0, True), (3.0, 2.9, False), (3.0, 1.0, False), (1.0, 1.1, False)],
)
def test_names_gain_nothing_where_as_much_is_left_beyond_noise(
    before: float, after: float, gain_nothing: bool
) -> None:
    assert squares(before, after).gain_nothing is gain_nothing


def test_one_stretch_far_beyond_noise_does_not_outweigh_all_others() -> None:
    noise = np.full(12, 100.0)
    before = np.append(np.full(11, 1e5), 1e9)
    after = np.append(np.full(11, 2e4), 1.1e9)
    found = Squares(noise, before, after, {})
    assert found.remainder is not None
    assert found.remainder > 1.0
    assert not found.gain_nothing
    assert Squares(noise, after, before, {}).gain_nothing


def test_a_law_without_which_unseen_stretches_are_met_better_is_the_one_to_withdraw() -> None:
    """Friction explains seven tenths; with ripple and a spring beside it more is left."""
    found = squares(11.0, 3.0, coulomb_friction=10.0, torque_ripple=1.5, elastic_return=2.5)
    names = ("coulomb_friction", "torque_ripple", "elastic_return")
    assert met_worse_with(names, found) == "torque_ripple"
    assert met_worse_with(names[::2], found) == "elastic_return"
    assert met_worse_with(names[:1], found) is None
    assert met_worse_with((), found) is None


def test_a_law_of_which_stretches_disagree_is_not_withdrawn() -> None:
    better, worse = np.tile([3.0, 2.5], 6) * NOISE, 3.0 * NOISE
    found = Squares(NOISE, 11.0 * NOISE, worse, {"backlash": better})
    assert met_worse_with(["backlash"], found) == "backlash"
    found = Squares(NOISE, 11.0 * NOISE, worse, {"backlash": np.tile([3.5, 2.4], 6) * NOISE})
    assert met_worse_with(["backlash"], found) is None
