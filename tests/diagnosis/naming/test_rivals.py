"""Effects that cannot be told apart are listed as often as the stated error rate says."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import norm

from gmfbo.diagnosis.naming.rivals import rivals_of
from gmfbo.physics import CATALOGUE
from tests.diagnosis.naming.linear_evidences import ROWS, WINDOWS, direction, evidence_of

DRAWS = 1200
SIZE = WINDOWS * ROWS


def share_listed(distance: float, truth: str, winner: str, other: str) -> float:
    """Share of draws in which the other is listed, two models this squared distance apart."""
    rng = np.random.default_rng(0)
    apart = np.sqrt(distance) * direction(1)
    listed = 0
    for _ in range(DRAWS):
        noise = rng.standard_normal(SIZE)
        left = {name: noise if name == truth else noise + apart for name in (winner, other)}
        found = [evidence_of(name, left[name], noise) for name in (winner, other)]
        listed += bool(rivals_of(found[0], found))
    return listed / DRAWS


@pytest.mark.parametrize("distance", [1.0, 4.0, 9.0])
def test_a_true_effect_is_among_the_rivals_in_95_draws_of_100(distance: float) -> None:
    """chi2(true) - chi2(winner) is N(-D, 4 D): 5 % lie beyond the bound, the false-alarm rate."""
    share = share_listed(distance, "transport_delay", "coulomb_friction", "transport_delay")
    # Three standard deviations of a share of 0.95 among as many draws.
    assert share == pytest.approx(0.95, abs=3.0 * np.sqrt(0.95 * 0.05 / DRAWS))


def test_a_true_effect_that_is_far_from_the_winner_is_always_a_rival() -> None:
    """It can hardly have lost: beyond D = 10.8 the bound is the winner's own chi2."""
    share = share_listed(60.0, "transport_delay", "coulomb_friction", "transport_delay")
    assert share > 0.995


@pytest.mark.parametrize("distance", [1.0, 4.0, 9.0])
def test_a_wrong_effect_is_listed_less_often_the_further_it_is_from_the_truth(
    distance: float,
) -> None:
    """Under the winner the difference is N(D, 4 D), so that 1.645 - sqrt(D) of it is below."""
    share = share_listed(distance, "coulomb_friction", "coulomb_friction", "transport_delay")
    expected = float(norm.cdf(1.645 - np.sqrt(distance)))
    assert share == pytest.approx(expected, abs=3.0 * np.sqrt(0.25 / DRAWS))


def test_a_wrong_effect_that_is_far_from_the_truth_is_never_a_rival() -> None:
    share = share_listed(60.0, "coulomb_friction", "coulomb_friction", "transport_delay")
    assert share == 0.0


@given(st.sampled_from(sorted(CATALOGUE)), st.sampled_from(sorted(CATALOGUE)))
def test_only_laws_that_contain_the_winner_are_left_out_of_equals(one: str, other: str) -> None:
    residual = direction(2)
    winner = evidence_of(one, residual, residual)
    found = rivals_of(winner, [winner, evidence_of(other, residual, residual)])
    law = CATALOGUE[other]
    is_listed = other != one and (one not in law.contains or one in law.flattens_to)
    assert [rival.name for rival in found] == ([other] if is_listed else [])


def test_a_law_that_contains_the_winner_is_no_rival_but_its_limit_is_one() -> None:
    residual = direction(3)
    coulomb = evidence_of("coulomb_friction", residual, residual)
    stribeck = evidence_of("stribeck_friction", residual, residual)
    assert rivals_of(coulomb, [stribeck]) == []
    assert rivals_of(stribeck, [coulomb]) == [coulomb]


def test_gravity_that_does_as_well_as_a_constant_torque_is_its_rival() -> None:
    """Its limit is no torque at all; it is nearly constant where the axis hardly turns."""
    residual = direction(3)
    offset = evidence_of("constant_torque_offset", residual, residual)
    gravity = evidence_of("gravity_torque", residual, residual)
    spring = evidence_of("elastic_return", residual, residual)
    assert rivals_of(offset, [gravity, spring]) == [gravity]
    assert rivals_of(gravity, [offset]) == [offset]


@pytest.mark.parametrize(
    "pair", [("actuator_lag", "sensor_lag"), ("actuator_gain_loss", "sensor_scale")]
)
@pytest.mark.parametrize(("share", "is_listed"), [(0.95, True), (0.75, False)])
def test_an_effect_at_the_other_end_of_the_loop_is_a_rival_if_it_gains_four_fifths(
    share: float, is_listed: bool, pair: tuple[str, str]
) -> None:
    """How physics is stepped sets the two further apart than noise does."""
    before = 100.0 * direction(4)
    left = (0.0 * before, np.sqrt(1.0 - share) * before)
    winner, other = (evidence_of(n, after, before) for n, after in zip(pair, left, strict=True))
    assert other.gain == pytest.approx(share * winner.gain)
    assert rivals_of(winner, [winner, other]) == ([other] if is_listed else [])


@given(st.sampled_from(sorted(CATALOGUE)))
def test_two_ends_of_a_loop_name_each_other(name: str) -> None:
    assert all(name in CATALOGUE[other].same_loop for other in CATALOGUE[name].same_loop)
