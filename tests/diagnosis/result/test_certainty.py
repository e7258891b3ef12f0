"""Nothing that a diagnosis says is surer than the probability that stands beside it."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import pytest

from gmfbo.cli.diagnosis.diagnosis_screen import screenful
from gmfbo.diagnosis import Diagnosis
from gmfbo.diagnosis.page.first_screen import verdict_words
from gmfbo.diagnosis.page.page import diagnosis_page
from gmfbo.diagnosis.result.certainty import (
    LEAST_FOR_A_FACT,
    claim,
    is_sure,
    label,
    statement_of,
    with_verb,
)
from gmfbo.diagnosis.result.explained import Remainder
from gmfbo.physics import CATALOGUE, Effect, Units
from tests.diagnosis.example_diagnoses import (
    FRICTION,
    OFFSET,
    friction,
    nothing,
    outside,
    parameters,
    rivals,
    too_little,
    weak,
)
from tests.physics.excitations import TYPICAL

BELOW = 0.799
UNITS = Units()
each_effect = pytest.mark.parametrize("effect", CATALOGUE.values(), ids=list(CATALOGUE))
SET = "one of constant torque offset, gravity torque, elastic return"


def fact_of(effect: Effect) -> str:
    return effect.statement(effect.starts(TYPICAL)[0], UNITS, UNITS.place)


def shown(made: Diagnosis) -> dict[str, str]:
    """All texts that a person reads of a diagnosis, by where they stand, on one line each."""
    page = re.sub(r"<script.*?</script>|<style.*?</style>", "", diagnosis_page(made), flags=re.S)
    texts = {
        "sentence": made.sentence,
        "terminal": "\n".join(screenful(made)),
        "prompt": repr(made),
        "notebook": made._repr_html_(),
        "page": re.sub(r"<[^>]+>", " ", page),
        "json": " ".join(effect["statement"] for effect in json.loads(made.to_json())["effects"]),
    }
    return {name: " ".join(text.replace("\xa0", " ").split()) for name, text in texts.items()}


@each_effect
def test_below_the_bar_every_law_of_the_catalogue_only_may_be(effect: Effect) -> None:
    said = with_verb(fact_of(effect), BELOW)
    assert len(re.findall(r"\bmay\b", said)) == 1
    assert not said.startswith("It may be so"), "the law's own verb is known"
    # Up to its verb nothing else changed, and the first verb is the weakened one.
    head = said.partition(" may ")[0]
    assert fact_of(effect).startswith(head)
    assert "is missing" not in head


@each_effect
def test_from_the_bar_on_a_statement_is_the_laws_own(effect: Effect) -> None:
    """Negative control: a sure name is not weakened."""
    assert with_verb(fact_of(effect), LEAST_FOR_A_FACT) == fact_of(effect)


def test_friction_may_be_missing() -> None:
    assert with_verb(FRICTION.statement, 0.62) == (
        "Coulomb friction of about 0.52 N m at the motor shaft may be missing from the twin."
    )


def test_a_sentence_with_an_unknown_verb_is_weakened_too() -> None:
    assert with_verb("The shaft bends.", BELOW) == "It may be so: The shaft bends."


def test_an_unknown_probability_is_not_sure() -> None:
    assert not is_sure(float("nan"))


def test_a_weak_name_is_a_fact_nowhere() -> None:
    for place, text in shown(weak()).items():
        assert "may be missing" in text, place
        assert "is missing" not in text, place
    for place in ("terminal", "prompt", "notebook"):
        assert "may be coulomb friction" in shown(weak())[place], place
    assert "May be coulomb friction" in shown(weak())["page"]
    assert "physics may be missing" in shown(weak())["page"]


def test_a_sure_name_is_a_fact_everywhere() -> None:
    """Negative control of the test above."""
    for place, text in shown(friction()).items():
        assert "is missing" in text, place
        assert "may be" not in text, place


def test_a_set_is_told_as_a_set_everywhere() -> None:
    for place, text in shown(rivals()).items():
        assert SET in text.replace("One of", "one of"), place
        assert "the recordings cannot tell them apart" in text, place
        assert "constant torque of about 0.11 N m is missing" not in text, place


def test_a_name_without_rivals_is_no_set() -> None:
    """Negative control of the test above."""
    assert all("one of" not in text.lower() for text in shown(friction()).values())


def test_a_set_says_what_would_tell_it_apart_where_that_is_known() -> None:
    told = "Play next.csv to tell constant torque offset from gravity torque."
    made = rivals()
    assert made.sentence.endswith(told)
    assert made.next_experiment is not None
    for planned in (
        None,
        replace(made.next_experiment, separates=("backlash", "cogging_torque")),
        replace(made.next_experiment, distance=made.next_experiment.threshold - 1.0),
        replace(made.next_experiment, reference=""),
    ):
        assert "Play" not in replace(made, next_experiment=planned).sentence


def test_where_no_reference_would_tell_more_none_is_asked_for() -> None:
    made = replace(rivals(), evidence="insufficient")
    assert made.next_experiment is not None
    assert "Record next.csv next." in made.sentence
    vain = replace(made, next_experiment=replace(made.next_experiment, reference="", why="In vain"))
    assert "Record" not in vain.sentence
    (told,) = [line for line in screenful(vain) if line.startswith("next ")]
    assert told.split(maxsplit=1)[1] == "In vain"


def test_rivals_beside_another_name_are_told_apart_too() -> None:
    made = rivals()
    assert made.next_experiment is not None
    beside = tuple(f"coulomb_friction + {name}" for name in OFFSET.set[:2])
    planned = replace(made.next_experiment, separates=beside)
    assert replace(made, next_experiment=planned).sentence.endswith(
        "Play next.csv to tell constant torque offset from gravity torque."
    )


def test_a_weak_set_may_be() -> None:
    said = statement_of("A constant torque of 0.1 N m is missing from the twin.", OFFSET.set, 0.6)
    assert said == (
        "One of constant torque offset, gravity torque, elastic return may be missing from the "
        "twin (the recordings cannot tell them apart)."
    )
    weaker = tuple(replace(r, probability=0.7 * r.probability) for r in OFFSET.rivals)
    assert claim(replace(OFFSET, rivals=weaker)) == f"may be {SET}"


def test_a_parameter_of_a_set_is_told_with_what_it_would_be() -> None:
    """It had been "one of torsional compliance, parameter:filter_time is missing"."""
    names, would_be = ("torsional_compliance", "parameter:filter_time"), "1.6 ms instead of 1 ms"
    said = statement_of("?", names, 0.9, {names[1]: would_be})
    assert said == (
        f"Torsional compliance is missing from the twin, or filter_time is {would_be} "
        "(the recordings cannot tell them apart)."
    )
    said = statement_of("?", ("backlash", *names), 0.7, {names[1]: would_be})
    assert said == (
        "One of backlash, torsional compliance may be missing from the twin, or filter_time may be "
        f"{would_be} (the recordings cannot tell them apart)."
    )


def test_a_drawing_asks_unless_one_name_is_sure() -> None:
    assert label(FRICTION) == "coulomb friction"
    assert label(OFFSET) == "constant torque offset?"
    assert label(weak().effects[0]) == "coulomb friction?"


def test_the_statement_has_the_probability_of_all_it_says() -> None:
    assert friction().statement_probability == 0.94
    assert rivals().statement_probability == pytest.approx(0.94 * 0.81)
    assert json.loads(rivals().to_json())["effects"][1]["set"] == list(OFFSET.set)


@pytest.mark.parametrize("made", [nothing(), parameters(), outside(), too_little()])
def test_a_verdict_without_names_invents_no_probability(made: Diagnosis) -> None:
    assert made.statement_probability is None
    assert json.loads(made.to_json())["statement_probability"] is None


def beside_unknown(share: float) -> Diagnosis:
    """Friction beside a function of the velocity that explains this share."""
    left = Remainder(share, "torque", "velocity", "throughout")
    return replace(outside(), effects=(FRICTION,), remainder=left)


def test_a_law_beside_something_unknown_is_the_nearest_and_no_surer_than_it_is() -> None:
    assert beside_unknown(0.62).sentence == (
        "None of the 29 effects known here that could be tested explains all that is missing. The "
        "nearest: Coulomb friction of about 0.52 N m at the motor shaft is missing from the twin. "
        "With it the torque command error on unseen recordings falls from 30 % to 6.0 % (noise "
        "floor 5.1 %); what is left still follows the reference. 62 % of what is more than "
        "noise is explained by no law; it depends on the velocity."
    )
    told = replace(outside(), effects=weak().effects).sentence
    assert "The nearest: Coulomb friction of about 0.52 N m at the motor shaft may be" in told


def test_laws_that_explain_most_are_told_before_what_they_leave() -> None:
    assert beside_unknown(0.22).sentence == (
        "Coulomb friction of about 0.52 N m at the motor shaft is missing from the twin; with it "
        "the torque command error on unseen recordings falls from 30 % to 6.0 % (noise floor "
        "5.1 %); what is left still follows the reference. 22 % of what is more than noise is "
        "explained by no law; it depends on the velocity."
    )


def test_the_page_calls_physics_known_where_laws_explain_most_of_it() -> None:
    assert verdict_words(beside_unknown(0.22)) == "known and unknown physics"
    assert verdict_words(beside_unknown(0.62)) == "unknown physics"
    unsure = replace(beside_unknown(0.22), effects=weak().effects)
    assert verdict_words(unsure) == "unknown physics"


def test_what_is_unknown_is_told_where_it_acts_even_if_no_curve_was_drawn_there() -> None:
    left = Remainder(1.0, "command", "command", "throughout")
    told = replace(outside(), remainder=left).sentence
    assert "that could be tested: it acts at the command port and depends on the command." in told


def test_no_more_is_left_by_laws_than_all() -> None:
    left = Remainder(2.99, None, None, "throughout")
    told = replace(outside(), effects=(FRICTION,), remainder=left).sentence
    assert "100 % of what is more than noise is explained by no law." in told
