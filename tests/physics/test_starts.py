"""Fits start inside their bounds, off zero, and at sizes that would be claimed."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gmfbo.physics import CATALOGUE, Effect, Excitation
from tests.physics.excitations import TYPICAL, excitations

effects = st.sampled_from(list(CATALOGUE.values()))


@given(effects, excitations())
@settings(max_examples=400, deadline=None)
def test_starts_lie_strictly_inside_their_bounds_and_off_zero(
    effect: Effect, excitation: Excitation
) -> None:
    bounds = effect.bounds(excitation)
    for start in effect.starts(excitation):
        for name, value in start.items():
            low, high = bounds[name]
            assert low < value < high, name
            assert value != 0.0


@given(effects, excitations())
@settings(max_examples=400, deadline=None)
def test_scales_and_floors_are_positive_and_finite(effect: Effect, excitation: Excitation) -> None:
    for name, scale in effect.scales(excitation).items():
        low, high = effect.bounds(excitation)[name]
        assert 0.0 < scale <= high - low, name
    assert 0.0 < effect.floor(excitation) < math.inf


@given(effects, excitations())
@settings(max_examples=400, deadline=None)
def test_fixed_parameters_are_positive_and_never_fitted_as_well(
    effect: Effect, excitation: Excitation
) -> None:
    fixed = effect.fixed(excitation)
    assert all(0.0 < value < math.inf for value in fixed.values())
    assert not set(fixed) & {parameter.name for parameter in effect.parameters}
    # What a comparison estimates beside them is fixed elsewhere, within the bounds of both.
    for nuisance in effect.own_nuisances:
        low, high = effect.bounds(excitation)[nuisance.name]
        assert low < fixed[nuisance.name] < high


@given(effects, excitations())
@settings(max_examples=400, deadline=None)
def test_every_start_is_of_a_size_that_would_be_claimed(
    effect: Effect, excitation: Excitation
) -> None:
    sizes = [effect.size(start, excitation) for start in effect.starts(excitation)]
    stiff = effect.name == "torsional_compliance"  # its windup may be below any resolution
    if stiff or effect.not_excited(excitation) is not None:
        assert min(sizes) > 0.0
    else:
        assert min(sizes) > effect.floor(excitation)


@given(excitations())
@settings(max_examples=200, deadline=None)
def test_floors_are_below_what_the_recordings_show(excitation: Excitation) -> None:
    shown = {
        "torque": excitation.torque,
        "position": excitation.stroke,
        "command": excitation.command,
        "1": 1.0,
        "command/s": excitation.command_rate,
    }
    for effect in CATALOGUE.values():
        if effect.size_unit in shown:
            assert effect.floor(excitation) < 0.11 * shown[effect.size_unit], effect.name


def test_shape_grids_are_small() -> None:
    counts = {name: len(effect.starts(TYPICAL)) for name, effect in CATALOGUE.items()}
    assert max(counts.values()) <= 12
    assert sum(counts.values()) <= 85


def test_strong_lines_become_starts_alone_and_then_all_together() -> None:
    found = replace(TYPICAL, wavenumbers=(7.0, 28.0, 14.0), frequencies=(50.0,))
    *alone, together = CATALOGUE["cogging_torque"].starts(found)
    assert [start["wavenumber_1"] for start in alone] == [7.0, 28.0, 14.0]
    assert all(len(start) == 3 for start in alone)
    assert [together[f"wavenumber_{i}"] for i in (1, 2, 3)] == [7.0, 28.0, 14.0]
    assert len(together) == 9
    (periodic,) = CATALOGUE["periodic_disturbance"].starts(found)
    assert periodic["frequency"] == 50.0


def test_eight_lines_start_together_and_the_four_strongest_alone() -> None:
    found = replace(TYPICAL, wavenumbers=tuple(range(5, 15)))
    *alone, together = CATALOGUE["cogging_torque"].starts(found)
    assert len(alone) == 4
    assert set(together) == {parameter.name for parameter in CATALOGUE["cogging_torque"].parameters}
    assert len(CATALOGUE["torque_ripple"].starts(found)) == 4


@given(excitations())
@settings(max_examples=200, deadline=None)
def test_a_friction_bristle_stays_stable_when_held_over_a_step(excitation: Excitation) -> None:
    deflection = CATALOGUE["coulomb_friction"].fixed(excitation)["deflection"]
    level = 0.1 * excitation.torque
    held = level * excitation.step**2 / (excitation.shaft_inertia * deflection)
    assert held <= 0.1001 or deflection == pytest.approx(0.01 * excitation.stroke)


@given(effects, excitations())
@settings(max_examples=300, deadline=None)
def test_reasons_for_no_excitation_are_words_or_none(
    effect: Effect, excitation: Excitation
) -> None:
    why = effect.not_excited(excitation)
    assert why is None or (why[0].islower() and not why.endswith("."))
