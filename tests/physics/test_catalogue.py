"""The catalogue is whole, consistent in itself, and says what physics.fmu says."""

from __future__ import annotations

import re
import zipfile
from dataclasses import replace
from xml.etree import ElementTree

import pytest

from gmfbo.physics import CATALOGUE, Effect
from gmfbo.sources.fmu_file.models import models_folder
from tests.physics.excitations import LINEAR, TYPICAL

NAMES = [
    "coulomb_friction",
    "stribeck_friction",
    "presliding_friction",
    "asymmetric_friction",
    "load_dependent_friction",
    "position_dependent_friction",
    "viscous_friction",
    "quadratic_drag",
    "backlash",
    "torsional_compliance",
    "hysteresis",
    "cogging_torque",
    "torque_ripple",
    "gravity_torque",
    "elastic_return",
    "constant_torque_offset",
    "actuator_saturation",
    "actuator_dead_zone",
    "actuator_rate_limit",
    "actuator_lag",
    "actuator_gain_loss",
    "transport_delay",
    "thermal_derating",
    "supply_voltage_limit",
    "magnetic_saturation",
    "sensor_eccentricity",
    "sensor_lag",
    "sensor_offset",
    "sensor_scale",
    "periodic_disturbance",
    "pulse_disturbance",
    "load_inertia",
]
STATES = {"position", "velocity", "command", "current", "acceleration", "time"}

each_effect = pytest.mark.parametrize("effect", CATALOGUE.values(), ids=list(CATALOGUE))


@pytest.fixture(scope="module")
def fmu_variables() -> set[str]:
    with zipfile.ZipFile(models_folder() / "physics.fmu") as archive:
        description = ElementTree.fromstring(archive.read("modelDescription.xml"))
    return {entry.attrib["name"] for entry in description.iter("ScalarVariable")}


def test_every_effect_is_listed_under_its_name_in_the_order_of_reports() -> None:
    assert list(CATALOGUE) == NAMES
    assert [effect.name for effect in CATALOGUE.values()] == NAMES


FURTHER_LINES = [f"_{i}" for i in range(2, 9)]
"""Of an effect that is fitted with as many lines as were found."""


@each_effect
def test_every_variable_that_an_effect_sets_is_in_the_fmu(
    effect: Effect, fmu_variables: set[str]
) -> None:
    start = effect.starts(TYPICAL)[0]
    names = {parameter.name for parameter in effect.parameters}
    assert set(effect.variables(dict.fromkeys(names, 1.0), TYPICAL)) <= fmu_variables
    further = {name for name in names if name[-2:] in FURTHER_LINES}
    assert names - further == set(start) - {nuisance.name for nuisance in effect.own_nuisances}
    assert not further or effect.family == "harmonic"


def test_every_effect_of_the_fmu_is_in_the_catalogue_with_all_its_parameters(
    fmu_variables: set[str],
) -> None:
    numbered = {name for name in fmu_variables if re.search(r"_[2-9]$", name)}
    ours = {
        variable
        for effect in CATALOGUE.values()
        for variable in effect.variables(effect.starts(TYPICAL)[0], TYPICAL)
    }
    prefixes = ("state.", "port.", "settings.", "tracking.")
    theirs = {name for name in fmu_variables if "." in name and not name.startswith(prefixes)}
    assert theirs - numbered == ours


@each_effect
def test_effects_name_each_other_rightly(effect: Effect) -> None:
    assert set(effect.confused_with) <= set(CATALOGUE) - {effect.name}
    assert set(effect.contains) <= set(CATALOGUE) - {effect.name}
    assert effect.confused_with, "an effect that nothing is confused with needs no diagnosis"
    assert all(words and not words.endswith(".") for words in effect.confused_with.values())


@each_effect
def test_words_are_those_of_the_report(effect: Effect) -> None:
    assert effect.port in {"torque", "command", "sensor"}
    assert effect.signal_path in {"controller", "actuator", "plant", "transmission", "sensor"}
    assert effect.region_state in STATES
    assert "=" in effect.equation
    assert effect.equation.isascii()
    assert re.search(r"\b1[6-9]\d\d|20\d\d", effect.source)


def test_what_an_effect_contains_acts_at_the_same_port() -> None:
    for effect in CATALOGUE.values():
        assert all(CATALOGUE[name].port == effect.port for name in effect.contains)


def test_only_effects_with_motion_of_their_own_need_a_simulation() -> None:
    assert {name for name, effect in CATALOGUE.items() if effect.signal is None} == {
        "backlash",
        "torsional_compliance",
    }
    assert {name for name, effect in CATALOGUE.items() if effect.inertia_share} == {
        "backlash",
        "torsional_compliance",
    }


def test_friction_is_not_testable_without_a_reversal() -> None:
    one_way = replace(TYPICAL, reversals=0)
    for effect in CATALOGUE.values():
        dry = effect.family == "friction" and effect.parameters[0].name != "coefficient"
        if dry or effect.name in ("backlash", "load_dependent_friction"):
            assert effect.not_excited(one_way) == "no reversal of the velocity"
            assert effect.not_excited(TYPICAL) is None


def test_a_load_behind_the_motor_needs_the_twins_inertia() -> None:
    unknown = replace(TYPICAL, inertia=None)
    for name in ("backlash", "torsional_compliance"):
        assert "inertia" in (CATALOGUE[name].not_excited(unknown) or "")
        assert CATALOGUE[name].not_excited(TYPICAL) is None


def test_gravity_needs_an_angle() -> None:
    gravity = CATALOGUE["gravity_torque"]
    assert gravity.not_excited(TYPICAL) is None
    assert "length" in (gravity.not_excited(LINEAR) or "")
