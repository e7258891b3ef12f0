"""The verdict in words: names, numbers and honesty about what is not known."""

from __future__ import annotations

from dataclasses import replace

import pytest

from gmfbo.diagnosis import Diagnosis
from gmfbo.diagnosis.result.estimated import Combination, EstimatedParameter
from gmfbo.diagnosis.result.explained import FreeRun, Remainder, Resembled
from gmfbo.diagnosis.result.held_out_errors import SignalFit
from gmfbo.diagnosis.result.reference_test import ResidualTest
from gmfbo.physics import CATALOGUE
from gmfbo.plain_words import interval, number, percent, quantity
from gmfbo.units import unit_words
from tests.diagnosis.example_diagnoses import (
    FIT,
    friction,
    nothing,
    outside,
    parameters,
    rivals,
    too_little,
    too_narrow,
)


def test_missing_physics_is_told_with_its_size_and_the_error_before_and_after() -> None:
    assert friction().sentence == (
        "Coulomb friction of about 0.52 N m at the motor shaft is missing from the twin; with it "
        "the torque command error on unseen recordings falls from 30 % to 6.0 % "
        "(noise floor 5.1 %); what is left still follows the reference."
    )


def test_a_range_that_is_too_narrow_is_told_before_anything_else() -> None:
    assert too_narrow().sentence == (
        "mech.J is at the end of its range. The recordings ask for 0.411 kg m2 where mech.J may be "
        "at most 0.3 kg m2 (ax7.toml, line 9): widen it there. With such values the twin explains "
        "the difference; no physics is missing."
    )


def test_a_value_at_the_end_of_its_range_is_told_before_unknown_physics_and_after_a_name() -> None:
    held = replace(too_narrow().parameters["mech.J"], value=0.3, low=0.29, high=0.3)
    at_end = (
        "mech.J is at the end of its range: mech.J may be at most 0.3 kg m2 (ax7.toml, line 9)."
    )
    unknown = replace(outside(), parameters={"mech.J": held}).sentence
    assert unknown.startswith(at_end)
    assert unknown.index("Something is missing") > len(at_end)
    named = replace(friction(), parameters={"mech.J": held}).sentence
    assert named.startswith("Coulomb friction")
    assert at_end in named


def test_control_values_within_their_ranges_are_told_without_the_ranges() -> None:
    assert "range" not in parameters().sentence
    assert "range" not in outside().sentence


def test_parameters_that_are_seen_only_together_are_told_as_what_is_seen() -> None:
    hidden = EstimatedParameter(8.0, 8.0, "kg", 2.0, 12.0, identifiable=False)
    found = replace(
        parameters(),
        parameters={"mass": hidden, "damping": hidden},
        combinations=(Combination("mass / damping", 0.35714, 0.356, 0.358),),
    )
    assert found.sentence == (
        "The twin's uncertain values explain the difference; of mass and damping these recordings "
        "tell only mass / damping = 0.357; no physics is missing."
    )


def test_rivals_are_in_the_sentence() -> None:
    told = rivals().sentence
    assert (
        "One of constant torque offset, gravity torque, elastic return is missing from the twin "
        "(the recordings cannot tell them apart)." in told
    )
    assert "With the first of each set the torque command error" in told


def test_physics_that_improves_no_signal_claims_no_improvement() -> None:
    flat = replace(FIT, signals={"position": SignalFit(0.1, 0.1, 0.1, 0.1, 0.05)})
    assert replace(friction(), fit=flat).sentence == friction().effects[0].statement


def test_an_error_that_no_digit_tells_from_what_it_was_does_not_fall() -> None:
    same = replace(FIT, signals={"position": SignalFit(0.1, 0.013604, 0.013602, 0.1, 0.0135)})
    told = replace(friction(), fit=same).sentence
    assert "with it the position error on unseen recordings hardly changes, it is 1.36 %" in told


def test_nothing_missing_is_told_with_the_noise_floor() -> None:
    assert nothing().sentence == (
        "Nothing is missing: the twin meets unseen recordings to the noise (position error "
        "0.19 %, noise floor 0.18 %)."
    )


def test_parameters_are_told_with_old_and_new_values() -> None:
    told = parameters().sentence
    assert told.startswith("The twin's uncertain values explain the difference: ")
    assert "mech.J is 0.121 kg m2 instead of 0.2" in told
    assert told.endswith("no physics is missing.")


def test_what_is_left_beside_right_values_is_told_and_not_called_nothing() -> None:
    """A fine error of an encoder was left beside "no physics is missing" (draw case 006)."""
    left = Remainder(0.7, None, None, "throughout")
    fine = {
        "torque_command": SignalFit(0.02, 0.013, 0.013, 0.013, 0.0135),
        "position": SignalFit(0.0007, 5.7e-5, 5.7e-5, 5.7e-5, 5.1e-5),
    }
    told = replace(parameters(), remainder=left, fit=replace(FIT, signals=fine)).sentence
    assert told.endswith(
        "no physics that is known here is missing, though more than noise is left (position error "
        "0.0057 %, noise floor 0.0051 %)."
    )
    none = replace(nothing(), remainder=left).sentence
    assert none.startswith("Nothing that is known here is missing, though more than noise is left")
    little = replace(nothing(), remainder=Remainder(0.004, None, None, "throughout")).sentence
    assert little == nothing().sentence


def test_a_function_is_told_with_the_law_that_it_looks_like() -> None:
    like = Remainder(1.0, "torque", "velocity", "throughout", Resembled("coulomb_friction", 0.93))
    told = replace(outside(), shape=None, remainder=like).sentence
    assert "depends on the velocity, most like coulomb friction (93 % of it)" in told
    assert "most like" not in replace(outside(), remainder=replace(like, resembles=None)).sentence


def test_the_size_of_what_has_no_name_is_one_that_is_sure() -> None:
    """The largest value of a curve may lie where its band tells nothing of the sign."""
    shape = outside().shape
    assert shape is not None
    vague = replace(shape, y=(0.3, -0.9, 0.1), y_low=(0.2, -2.0, -0.1), y_high=(0.4, 0.5, 0.2))
    assert vague.largest == 0.3
    assert "up to 0.3 N m at the torque port" in replace(outside(), shape=vague).sentence
    none = replace(vague, y_low=(-1.0, -2.0, -0.1))
    told = replace(outside(), shape=none).sentence
    assert "it acts at the torque port and depends on the velocity" in told


def test_what_has_no_name_is_told_with_its_largest_size() -> None:
    tested = len(CATALOGUE) - len(outside().not_testable)
    told = outside().sentence
    assert f"none of the {tested} effects known here that could be tested" in told
    told = replace(outside(), not_testable=()).sentence
    assert f"none of the {len(CATALOGUE)} effects known here: up to 0.4 N m" in told
    told = outside().sentence
    assert "up to 0.4 N m at the torque port that depends on the velocity" in told


def test_too_little_evidence_is_never_told_as_nothing_missing() -> None:
    told = too_little().sentence
    assert told.startswith("These recordings cannot tell")
    assert "Nothing is missing" not in told
    assert "1 of the known effects" in told
    assert "next.csv" in told


def test_certain_physics_with_too_little_evidence_says_that_more_may_be_missing() -> None:
    told = replace(friction(), evidence="insufficient").sentence
    assert told.startswith("Coulomb friction")
    assert "These recordings cannot tell more." in told


@pytest.mark.parametrize(
    ("share", "said"),
    [
        (0.306, "31 %"),
        (0.06, "6.0 %"),
        (0.0996, "10 %"),
        (0.00204, "0.20 %"),
        (1.0, "100 %"),
        (float("nan"), "-"),
    ],
)
def test_a_share_is_told_with_two_digits(share: float, said: str) -> None:
    assert percent(share) == said


def test_units_read_as_words_and_none_for_plain_numbers() -> None:
    assert (unit_words("kg.m2"), unit_words("1"), quantity(2.0, "1")) == ("kg m2", "", "2")


def test_an_interval_that_is_not_known_is_left_out() -> None:
    assert interval(0.5213, 0.49, 0.55, "N.m") == "0.521 [0.49, 0.55] N m"
    assert interval(0.5213, float("nan"), 0.55, "N.m") == "0.521 N m"
    assert number(float("inf")) == "-"


def test_what_follows_the_reference_is_not_called_nothing() -> None:
    """Rows of a slow logger left 12 % of a command's error, and "no physics is missing"."""
    follows = ResidualTest("rec3.csv", "torque_command", 0.13, 0.12, 0.006, 0.0041)
    told = replace(parameters(), residual_tests=(follows,)).sentence
    assert told.endswith("though what is left still follows the reference.")
    told = replace(nothing(), residual_tests=(follows,)).sentence
    assert told.startswith("Nothing that is known here is missing, though what is left still")
    small = replace(follows, follows=0.004, bound=0.0001)
    assert replace(nothing(), residual_tests=(small,)).sentence == nothing().sentence


def test_a_fixed_value_is_told_with_its_line_and_with_what_may_be_wrong_in_its_place() -> None:
    wrong = EstimatedParameter(
        1.0, 1.6, "ms", 1.59, 1.61, stated="ax7.toml, line 12", fixed=True,
        set=("parameter:filter_time", "parameter:bus_time"),
    )  # fmt: skip
    told = replace(parameters(), parameters={"filter_time": wrong}).sentence
    assert "filter_time is 1.6 ms instead of 1 (fixed in ax7.toml, line 12; or bus_time" in told
    own = replace(wrong, stated="ax7.toml", set=("parameter:filter_time",))
    told = replace(parameters(), parameters={"filter_time": own}).sentence
    assert "(fixed in the FMU; [parameters] of ax7.toml sets it)" in told


def test_the_error_beside_a_fixed_value_is_that_of_the_twin_with_the_right_one() -> None:
    wrong = EstimatedParameter(1.0, 1.6, "ms", 1.59, 1.61, stated="a.toml, line 1", fixed=True)
    with_it = replace(FIT, signals={"position": SignalFit(0.3, 0.2, 0.06, 0.2, 0.05)})
    left = Remainder(0.1, None, None, "throughout")
    found = replace(parameters(), parameters={"filter_time": wrong}, fit=with_it, remainder=left)
    assert "position error 6.0 %" in found.sentence


def test_a_fixed_value_that_is_wrong_beside_an_effect_is_in_the_sentence() -> None:
    wrong = EstimatedParameter(
        1.0, 1.6, "ms", 1.59, 1.61, stated="ax7.toml, line 12", fixed=True,
        set=("parameter:filter_time",),
    )  # fmt: skip
    told = replace(friction(), parameters={"filter_time": wrong}).sentence
    assert told.startswith("Coulomb friction of about 0.52 N m")
    assert told.endswith(" filter_time is 1.6 ms instead of 1 (fixed in ax7.toml, line 12).")


def test_a_fixed_value_is_told_no_surer_than_it_is() -> None:
    weak = EstimatedParameter(
        1.0, 1.6, "ms", 1.59, 1.61, stated="ax7.toml, line 12", fixed=True,
        set=("parameter:filter_time",), probability=0.62,
    )  # fmt: skip
    made = replace(parameters(), parameters={"filter_time": weak})
    assert "filter_time may be 1.6 ms instead of 1" in made.sentence
    assert "(fixed in ax7.toml, line 12; probability 0.62)" in made.sentence
    assert made.statement_probability == 0.62
    sure = replace(made, parameters={"filter_time": replace(weak, probability=0.9)})
    assert "filter_time is 1.6 ms instead of 1" in sure.sentence
    beside = replace(friction(), parameters={"filter_time": weak})
    assert beside.statement_probability == 0.94 * 0.62


@pytest.mark.parametrize("found", [nothing(), parameters()])
def test_an_open_loop_twin_that_runs_away_uncorrected_is_told(found: Diagnosis) -> None:
    def met(free: float) -> Diagnosis:
        fit = replace(found.fit.signals["position"], free_run=FreeRun(free, free, float("nan")))
        return replace(found, fit=replace(found.fit, signals={"position": fit}))

    told = "Over whole recordings, where nothing corrects the twin, the position error is 31 %."
    assert told in met(0.31).sentence
    assert "Over whole recordings" not in met(0.002).sentence
