"""Claims are the smallest sets that meet what is believed, whatever row is best."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.diagnosis.comparison.claims import (
    Claim,
    Shares,
    claims_of,
    posterior_draws,
    shares_above_floor,
)
from gmfbo.diagnosis.comparison.evidence import Grams
from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.ledger import Scored
from gmfbo.diagnosis.comparison.numbers import NAMED
from gmfbo.diagnosis.comparison.priors import priors_of
from gmfbo.diagnosis.fitting.hypothesis import Hypothesis, Setting
from gmfbo.sources.twin.uncertain import Uncertain
from tests.physics.excitations import TYPICAL

Beliefs = Mapping[tuple[str, ...], float]


def claims(beliefs: Beliefs, above: Mapping[str, float] | None = None) -> tuple[Claim, ...]:
    rows = tuple(frozenset(names) for names in beliefs)
    values = np.array(list(beliefs.values()))
    scored = Scored(rows, np.log(values + 1e-300)[:, None], values, 0.0 * values)
    return claims_of(scored, {r: Shares({n: (above or {}).get(n, 1.0) for n in r}) for r in rows})


def told(beliefs: Beliefs, above: Mapping[str, float] | None = None) -> list[set[str]]:
    return [set(c.members) for c in claims(beliefs, above) if c.probability >= NAMED]


def test_each_of_two_effects_of_one_row_is_named() -> None:
    beliefs = {("backlash", "cogging_torque"): 0.99, ("backlash",): 0.01}
    assert told(beliefs) == [{"backlash"}, {"cogging_torque"}]


def test_laws_that_replace_each_other_are_a_set_where_the_best_row_has_two_of_them() -> None:
    """The best row holds both, which each other row takes for one."""
    beliefs = {
        ("load_dependent_friction", "position_dependent_friction"): 0.4,
        ("position_dependent_friction",): 0.35,
        ("load_dependent_friction",): 0.25,
    }
    assert told(beliefs) == [{"position_dependent_friction", "load_dependent_friction"}]
    assert claims(beliefs)[0].probability == pytest.approx(1.0)


def test_a_set_of_a_law_and_its_limit_is_the_limit() -> None:
    assert told({("coulomb_friction",): 0.6, ("stribeck_friction",): 0.4}) == [{"coulomb_friction"}]


def test_a_law_below_its_floor_is_its_limit() -> None:
    """A spring whose stiffness may be none is a constant torque: of the two one is there."""
    rows = (frozenset({"elastic_return"}), frozenset({"constant_torque_offset"}))
    beliefs = np.array([0.7, 0.3])
    scored = Scored(rows, np.log(beliefs)[:, None], beliefs, 0.0 * beliefs)
    spring = Shares({"elastic_return": 0.6}, {"elastic_return": {"constant_torque_offset": 0.4}})
    (told,) = claims_of(scored, {rows[0]: spring, rows[1]: Shares()})
    assert told.members == ("constant_torque_offset",)
    assert told.beliefs == pytest.approx((1.0,))
    sure = Shares({"elastic_return": 0.99}, {"elastic_return": {"constant_torque_offset": 0.01}})
    (told,) = claims_of(scored, {rows[0]: sure, rows[1]: Shares()})
    assert told.members == ("elastic_return", "constant_torque_offset")
    assert told.beliefs == pytest.approx((0.693, 0.307))


def test_laws_of_which_every_row_has_one_are_a_set_beside_a_likelier_law_of_most_rows() -> None:
    """A part of a recording of a real axis: its rows, and their shares above the floors."""
    rest = {"cogging_torque", "stribeck_friction"}
    beliefs = {
        tuple(sorted({*rest, "asymmetric_friction", "hysteresis"})): 0.41,
        tuple(sorted({*rest, "asymmetric_friction", "presliding_friction"})): 0.41,
        tuple(sorted({*rest, "presliding_friction"})): 0.16,
        ("cogging_torque", "hysteresis"): 0.01,
        ("cogging_torque", "presliding_friction"): 0.01,
    }
    assert told(beliefs, {"stribeck_friction": 0.9}) == [
        {"cogging_torque"},
        {"presliding_friction", "hysteresis"},
        {"stribeck_friction", "asymmetric_friction"},
    ]


def test_members_of_a_set_stand_for_each_other_where_they_can() -> None:
    """A speed loop of counts: friction and a delay meet every row too, but most rows hold both."""
    beliefs: Beliefs = {
        ("coulomb_friction", "transport_delay"): 0.762,
        ("load_dependent_friction", "transport_delay"): 0.142,
        ("stribeck_friction", "transport_delay"): 0.039,
        ("actuator_lag", "coulomb_friction"): 0.057,
    }
    assert told(beliefs, {"actuator_lag": 0.94}) == [
        {"transport_delay", "actuator_lag"},
        {"coulomb_friction"},
    ]


def test_no_set_has_two_laws_that_most_rows_hold_together_where_a_larger_one_has_none() -> None:
    """The position loop of a real motor: friction of some kind, and a command that comes late."""
    rate, delay = "actuator_rate_limit", "transport_delay"
    beliefs = {
        (rate, "hysteresis"): 0.666,
        (rate, "stribeck_friction"): 0.122,
        (rate, "presliding_friction"): 0.096,
        (delay, "hysteresis"): 0.076,
        ("hysteresis",): 0.02,
        ("presliding_friction",): 0.02,
    }
    assert told(beliefs) == [
        {rate, delay},
        {"hysteresis", "stribeck_friction", "presliding_friction"},
    ]


def test_nothing_is_told_where_nothing_is_believed_or_all_is_below_its_floor() -> None:
    assert told({(): 0.5, ("backlash",): 0.5}) == []
    assert told({("backlash",): 1.0}, {"backlash": 0.3}) == []


@pytest.mark.parametrize(
    ("value", "least", "most"),
    [(1.6e-3, 0.99, 1.0), (0.991e-3, 0.0, 0.01), (1.02e-3, 0.3, 0.7)],
)
def test_a_fixed_parameter_counts_by_how_likely_it_changed_by_more_than_anybody_cares(
    value: float, least: float, most: float
) -> None:
    """Stated as 1 ms, and seen within 0.3 %."""
    stated = Uncertain("filter_time", 1e-3, 0.25e-3, 4e-3)
    excitation = TYPICAL
    hypothesis = Hypothesis(Setting((stated,), excitation))
    priors = priors_of(hypothesis, ["filter_time"])
    fitted = Fitted(
        hypothesis,
        ("filter_time",),
        priors,
        np.array([priors[0].to_u(value)]),
        np.zeros(0),
        [],
        [],
        [],
        [],
        True,
        np.zeros(0, dtype=bool),
    )
    shares = shares_above_floor(fitted, seen_within(0.003, fitted, stretches=1))
    assert least <= shares.above["parameter:filter_time"] <= most


def seen_within(deviation: float, fitted: Fitted, stretches: int, apart: float = 0.0) -> Grams:
    """Of one quantity: its deviation by noise, and by how many of these stretches differ."""
    information = deviation**-2 / stretches
    asked = apart * np.sqrt(information) * np.resize([1.0, -1.0], stretches)
    at_the_top = fitted.slopes / stretches
    return Grams(
        np.full((stretches, 1, 1), information),
        (asked + at_the_top)[:, None],
        np.zeros(stretches),
    )


@given(st.floats(0.0, 20.0), st.integers(3, 60))
def test_draws_spread_as_noise_and_as_what_stretches_ask_for(apart: float, pairs: int) -> None:
    """The variance of the bagged posterior is the sum of both (Huggins and Miller 2023)."""
    hypothesis = Hypothesis(Setting((Uncertain("inertia", 1.0, 0.5, 2.0),), TYPICAL))
    priors = priors_of(hypothesis, [])
    fitted = Fitted(
        hypothesis,
        (),
        priors,
        np.array([priors[0].to_u(1.0)]),
        np.zeros(0),
        [],
        [],
        [],
        [],
        True,
        np.zeros(0, dtype=bool),
    )
    inner = seen_within(1e-3, fitted, stretches=2 * pairs, apart=apart)
    drawn = np.array([priors[0].to_u(x) for (x,) in posterior_draws(fitted, inner)])
    expected = 1e-3 * np.sqrt(1.0 + apart**2)
    assert np.std(drawn) == pytest.approx(expected, rel=0.35)


def test_a_rare_law_may_belong_to_the_smallest_set() -> None:
    a, b, c, k = "backlash", "cogging_torque", "elastic_return", "quadratic_drag"
    beliefs = {(a, c): 0.31, (b, c): 0.31, (a,): 0.155, (b,): 0.155, (k,): 0.04, ("x",): 0.03}
    assert told(beliefs)[0] == {a, b, k}


def test_many_laws_that_explain_the_same_are_one_set() -> None:
    """All subsets of 24 could not be looked at."""
    (found,) = told({(f"law {k}",): 1.0 / 24 for k in range(24)})
    assert len(found) == 23


names = st.sampled_from(["backlash", "cogging_torque", "elastic_return", "quadratic_drag"])
tables = st.dictionaries(
    st.frozensets(names, max_size=3).map(lambda row: tuple(sorted(row))),
    st.floats(0.01, 1.0),
    min_size=1,
    max_size=6,
)


@given(tables)
def test_a_told_probability_is_the_belief_in_rows_that_hold_one_of_the_set(table: Beliefs) -> None:
    whole = sum(table.values())
    beliefs = {row: value / whole for row, value in table.items()}
    first, *_ = (*claims(beliefs), None)
    if first is None:
        assert list(beliefs) == [()]
        return
    held = sum(v for row, v in beliefs.items() if set(row) & set(first.members))
    assert first.probability == pytest.approx(held)
    assert len({*first.members}) == len(first.members)


def overlap(names: Iterable[str], beliefs: Beliefs) -> tuple[float, float]:
    """Belief in rows with one of a set, and in each further one that a row has."""
    own = {row: len(set(row) & set(names)) for row in beliefs}
    met = sum(value for row, value in beliefs.items() if own[row])
    return met, sum(value * (own[row] - 1) for row, value in beliefs.items() if own[row])


@given(tables)
def test_no_smaller_set_meets_as_much(table: Beliefs) -> None:
    whole = sum(table.values())
    beliefs = {row: value / whole for row, value in table.items()}
    there = sum(value for row, value in beliefs.items() if row)
    all_names = {n for row in beliefs for n in row}
    for first in claims(beliefs)[:1] if there >= NAMED else ():
        assert first.probability >= NAMED * there - 1e-12
        sizes = range(1, len(all_names) + 1)
        sets = [one for count in sizes for one in combinations(sorted(all_names), count)]
        enough = [one for one in sets if overlap(one, beliefs)[0] >= NAMED * there]
        shortest = [one for one in enough if len(one) == len(enough[0])]
        sure = max(shortest, key=lambda one: -overlap(one, beliefs)[1] + overlap(one, beliefs)[0])
        least = NAMED if overlap(sure, beliefs)[0] >= NAMED else NAMED * there
        apart = [
            one
            for one in enough
            if overlap(one, beliefs)[0] >= least
            and overlap(one, beliefs)[1] <= (1.0 - NAMED) * there
        ]
        assert len(first.members) == len(apart[0] if apart else enough[0])
        assert not apart or overlap(first.members, beliefs)[1] <= (1.0 - NAMED) * there
