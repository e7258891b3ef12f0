"""What is said of an effect is one plain sentence with a number and a unit."""

from __future__ import annotations

import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gmfbo.physics import CATALOGUE, Effect, Excitation, Units
from gmfbo.physics.harmonic import strongest_first
from tests.physics.excitations import LINEAR, TYPICAL, excitations

ROTARY = Units()
SLIDE = Units(torque="N", position="m", velocity="m/s", command="V", current="V", load="V")
effects = st.sampled_from(list(CATALOGUE.values()))
each_effect = pytest.mark.parametrize("effect", CATALOGUE.values(), ids=list(CATALOGUE))


def check_sentence(text: str) -> None:
    assert text[0].isupper()
    assert text.endswith(".")
    assert ". " not in text, "one sentence"
    assert re.search(r"\d", text)
    assert not set(text) & set("{}[]_\n"), text
    assert not re.search(r"nan|inf\b|e[+-]\d", text), text


@given(effects, excitations(), st.data())
@settings(max_examples=400, deadline=None)
def test_a_statement_is_one_sentence_for_any_values_within_the_bounds(
    effect: Effect, excitation: Excitation, data: st.DataObject
) -> None:
    drawn = {
        name: low + (high - low) * data.draw(st.floats(0.001, 0.999), label=name)
        for name, (low, high) in effect.bounds(excitation).items()
    }
    units = ROTARY if excitation.angular else SLIDE
    text = effect.statement(drawn, units, units.place)
    assert text[0].isupper()
    assert text.endswith(".")
    assert ". " not in text
    assert re.search(r"\d", text)
    assert not set(text) & set("{}[]_\n")


@each_effect
@pytest.mark.parametrize("units", [ROTARY, SLIDE], ids=["rotary", "linear"])
def test_a_statement_has_a_number_with_its_unit(effect: Effect, units: Units) -> None:
    excitation = TYPICAL if units is ROTARY else LINEAR
    text = effect.statement(effect.starts(excitation)[0], units, units.place)
    check_sentence(text)
    assert re.search(
        r"\d (%|m?N\b|m?V|[mu]?m\b|[mu]?rad|[mu]?s\b|kg|Hz|cycles|of the command)", text
    )


@each_effect
def test_a_statement_on_a_linear_axis_speaks_of_no_shaft(effect: Effect) -> None:
    text = effect.statement(effect.starts(LINEAR)[0], SLIDE, SLIDE.place)
    assert "shaft" not in text
    assert " torque" not in text
    assert "turn" not in text.replace("return", "")


@each_effect
@pytest.mark.parametrize("units", [ROTARY, SLIDE], ids=["rotary", "linear"])
def test_a_region_names_its_state(effect: Effect, units: Units) -> None:
    excitation = TYPICAL if units is ROTARY else LINEAR
    text = effect.region(effect.starts(excitation)[0], units)
    assert effect.region_state in text
    assert not set(text) & set("{}[]_\n")
    assert text[0].islower()
    assert not text.endswith(".")


def test_coulomb_friction_is_said_as_an_engineer_would() -> None:
    text = CATALOGUE["coulomb_friction"].statement({"level": 0.5193}, ROTARY, ROTARY.place)
    assert text == "Coulomb friction of about 0.52 N m at the motor shaft is missing from the twin."


def test_friction_by_direction_says_what_differs() -> None:
    say = CATALOGUE["asymmetric_friction"].statement
    levels = {"level_positive": 0.2, "level_negative": 0.1}
    assert "viscous" not in say(levels, ROTARY, ROTARY.place)
    text = say({**levels, "viscous_difference": -0.038}, ROTARY, ROTARY.place)
    assert "0.2 N m in positive and 0.1 N m in negative direction" in text
    assert text.endswith("0.038 N m/(rad/s) less of viscous friction in positive direction.")


def test_cogging_is_counted_in_cycles() -> None:
    cogging = CATALOGUE["cogging_torque"]
    line = {"wavenumber_1": 7.0, "sine_1": 0.03, "cosine_1": 0.04}
    assert "about 0.05 N m" in cogging.statement(line, ROTARY, ROTARY.place)
    assert cogging.region(line, ROTARY) == "over the position, 7 cycles a turn"
    per_metre = {"wavenumber_1": 2.0 * 3.141592653589793 * 400.0, "sine_1": 1.0, "cosine_1": 0.0}
    assert "400 cycles per m" in cogging.statement(per_metre, SLIDE, SLIDE.place)


def cogging_of(*amplitudes: float) -> dict[str, float]:
    """Lines of 7, 14, 21 ... cycles a turn."""
    return {
        name: value
        for i, size in enumerate(amplitudes, 1)
        for name, value in ((f"wavenumber_{i}", 7.0 * i), (f"sine_{i}", size), (f"cosine_{i}", 0.0))
    }


def test_cogging_of_several_lines_names_the_three_strongest() -> None:
    cogging = CATALOGUE["cogging_torque"]
    two = cogging_of(0.02, 0.05)
    assert cogging.statement(two, ROTARY, ROTARY.place) == (
        "Cogging at the motor shaft of about 0.05 N m with 14 and 0.02 N m with 7 cycles a turn "
        "is missing from the twin."
    )
    assert cogging.region(two, ROTARY) == "over the position, 14 and 7 cycles a turn"
    five = cogging_of(0.01, 0.05, 0.03, 0.02, 0.005)
    assert "with 14, 0.03 N m with 21 and 0.02 N m with 28 cycles a turn and 2 weaker lines" in (
        cogging.statement(five, ROTARY, ROTARY.place)
    )
    four = cogging.region(cogging_of(0.04, 0.03, 0.02, 0.01), ROTARY)
    assert four.endswith("7, 14 and 21 cycles a turn and 1 weaker line")


def test_lines_are_numbered_by_their_amplitude() -> None:
    ranked = strongest_first({**cogging_of(0.02, -0.05, 0.03), "level": 1.0})
    assert [ranked[f"sine_{i}"] for i in (1, 2, 3)] == [-0.05, 0.03, 0.02]
    assert [ranked[f"wavenumber_{i}"] for i in (1, 2, 3)] == [14.0, 21.0, 7.0]
    assert ranked["level"] == 1.0
    assert len(ranked) == 10


def test_a_gain_that_is_too_high_is_not_called_a_loss() -> None:
    gain = CATALOGUE["actuator_gain_loss"]
    assert "8 % less" in gain.statement({"loss": 0.08}, ROTARY, ROTARY.place)
    assert "8 % more" in gain.statement({"loss": -0.08}, ROTARY, ROTARY.place)


def test_friction_over_the_position_is_told_by_its_least_and_most() -> None:
    rubbing = {"level": 0.001, "sine": 0.003, "cosine": 0.004, "wavenumber": 1.0}
    law = CATALOGUE["position_dependent_friction"]
    assert "between 0 N m and 0.006 N m" in law.statement(rubbing, ROTARY, ROTARY.place)
    tight = {**rubbing, "level": 0.02}
    assert "between 0.015 N m and 0.025 N m" in law.statement(tight, ROTARY, ROTARY.place)
