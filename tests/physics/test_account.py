"""What is told of an effect is what a diagnosis asks for and says."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import pytest

from gmfbo.diagnosis.screening.testable_effects import untestable
from gmfbo.errors import InputError
from gmfbo.physics import CATALOGUE, Effect, Excitation
from gmfbo.physics.account import example_sentence, full_account, short_account
from gmfbo.physics.example_axis import EXAMPLE_AXIS
from gmfbo.physics.needs import hidden_by, needed_states
from gmfbo.sources.twin_file.twin_file import TwinFile


def reasons(effect: Effect, states: set[str], port: str, inertia: bool = True) -> str | None:
    """Why a twin with just these entries cannot test the effect; None where it can."""
    file = TwinFile(
        name="axis",
        fmu="axis.fmu",
        step=1e-3,
        inputs={"reference": "r"},
        outputs={"position": "y"},
        gains={},
        ports={port: "p"},
        states=dict.fromkeys(states, "y"),
    )
    told = untestable(file, EXAMPLE_AXIS, has_inertia=inertia, is_open=False)
    return told.get(effect.name)


@pytest.mark.parametrize("effect", CATALOGUE.values(), ids=lambda effect: effect.name)
def test_a_twin_with_what_is_told_can_test_the_effect_and_one_with_less_cannot(
    effect: Effect,
) -> None:
    needed = needed_states(effect)
    for chosen in product(*(entry.any_of for entry in needed)):
        assert reasons(effect, set(chosen), effect.port) is None
        other = next(port for port in ("torque", "command", "sensor") if port != effect.port)
        assert reasons(effect, set(chosen), other) == f"the twin has no {effect.port} port"
    for entry in needed:
        rest = {"position", "velocity", "command", "current"} - set(entry.any_of)
        assert reasons(effect, rest, effect.port) == entry.lacking
    everything = {"position", "velocity", "command"}
    said = reasons(effect, everything, effect.port, inertia=False) or ""
    assert ("inertia" in said) == effect.inertia_share
    assert ("inertia under [roles]" in dict(short_account(effect))["needs"]) == effect.inertia_share


@pytest.mark.parametrize("effect", CATALOGUE.values(), ids=lambda effect: effect.name)
def test_an_account_holds_law_sentence_and_source(effect: Effect) -> None:
    told = full_account(effect)
    assert dict(told)["law"] == effect.equation
    assert dict(told)["says"].endswith(".")
    assert dict(told)["source"] == effect.source
    shown = " ".join(text for head, text in told if head == "parameter")
    assert all(parameter.name in shown for parameter in effect.parameters)


def test_reasons_that_hide_an_effect_are_its_own() -> None:
    assert hidden_by(CATALOGUE["coulomb_friction"]) == ("no reversal of the velocity",)
    assert hidden_by(CATALOGUE["thermal_derating"]) == ("no recording is long enough to warm up",)
    assert hidden_by(CATALOGUE["viscous_friction"]) == ()
    assert "the sampling is too coarse" in hidden_by(CATALOGUE["transport_delay"])[0]


def test_the_example_hides_no_effect_but_those_that_need_another_axis() -> None:
    """Control: reasons come from what differs, not from the example itself."""
    assert [e.name for e in CATALOGUE.values() if e.not_excited(EXAMPLE_AXIS)] == []


def test_an_added_effect_whose_functions_fail_is_named_in_one_line() -> None:
    def fails(excitation: Excitation) -> str | None:
        raise ZeroDivisionError("float division by zero")

    broken = replace(CATALOGUE["elastic_return"], name="bellows", not_excited=fails)
    with pytest.raises(InputError, match=r"'bellows'.*not_excited.*ZeroDivisionError: float"):
        short_account(broken)
    no_start = replace(CATALOGUE["elastic_return"], name="bellows", starts=lambda e: [])
    with pytest.raises(InputError, match=r"'bellows'.*starts and statement.*IndexError"):
        example_sentence(no_start)
