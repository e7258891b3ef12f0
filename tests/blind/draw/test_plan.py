"""Which cases a draw has."""

from __future__ import annotations

from collections import Counter

from gmfbo.physics import CATALOGUE
from tests.blind.draw.nulls import VARIANTS
from tests.blind.draw.plan import DEVELOPMENT, DEVELOPMENT_SEED, REGISTERED, draw_plan
from tests.blind.machines import MACHINES
from tests.blind.outside import LAWS_OUTSIDE, OUTSIDE
from tests.blind.plan import make_plan


def test_the_registered_draw_has_seven_hundred_cases_and_forty_nulls_of_each_kind() -> None:
    cases = draw_plan(REGISTERED, 5)
    assert len(cases) == 700
    assert Counter(case.stratum for case in cases) == REGISTERED
    families = Counter(case.family for case in cases if case.stratum == "null")
    assert families == dict.fromkeys(VARIANTS, 40)


def test_the_development_draw_has_a_hundred_cases_of_every_kind() -> None:
    cases = draw_plan(DEVELOPMENT, DEVELOPMENT_SEED)
    assert Counter(case.stratum for case in cases) == DEVELOPMENT
    assert sum(DEVELOPMENT.values()) == 100
    families = Counter(case.family for case in cases if case.stratum == "null")
    assert set(families) == set(VARIANTS)
    assert set(families.values()) == {5, 6}


def test_every_variant_of_a_null_is_in_the_registered_draw() -> None:
    drawn = {(case.family, case.variant) for case in draw_plan(REGISTERED, 5)}
    assert drawn >= {(family, name) for family, own in VARIANTS.items() for name in own}


def test_what_is_owed_is_within_reach_and_every_law_is_asked_for() -> None:
    owed = [case.plan for case in draw_plan(REGISTERED, 6) if case.stratum == "owed"]
    assert all(plan.is_within_reach and plan.band == "owed" for plan in owed)
    counts = Counter(plan.effects[0] for plan in owed)
    assert set(counts) == set(CATALOGUE) - {"sensor_offset"}  # no machine has an absolute place
    assert max(counts.values()) - min(counts.values()) <= 1


def test_at_least_twelve_laws_outside_the_library_are_drawn() -> None:
    laws = {
        c.plan.effects for c in draw_plan(DEVELOPMENT, DEVELOPMENT_SEED) if c.stratum == "outside"
    }
    assert len(laws) >= 12
    assert not set(LAWS_OUTSIDE) & set(CATALOGUE)


def test_control_laws_that_came_later_are_in_no_plan_of_the_blind_benchmark() -> None:
    """Its seeds give the cases that they gave."""
    drawn = {plan.effects[0] for plan in make_plan(510, 5) if plan.kind == "outside"}
    assert drawn == set(OUTSIDE)


def test_the_same_seed_gives_the_same_plan_and_another_one_does_not() -> None:
    assert draw_plan(DEVELOPMENT, 1) == draw_plan(DEVELOPMENT, 1)
    assert draw_plan(DEVELOPMENT, 1) != draw_plan(DEVELOPMENT, 2)


def test_every_machine_of_a_variant_exists() -> None:
    for own in VARIANTS.values():
        for variant in own.values():
            assert set(variant.machines) <= {*MACHINES, "rich"}
