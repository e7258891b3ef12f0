"""Columns as loggers name them, and the signals that they are taken for."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.recordings import SignalSpec
from gmfbo.recordings.columns.column_guesses import guess_columns
from gmfbo.recordings.columns.columns import Column
from gmfbo.recordings.csv.header import split_unit

AXIS = {
    "reference": SignalSpec("reference", "reference", unit="rad", driven=True),
    "position": SignalSpec("position", "position", unit="rad", compared=True),
    "velocity": SignalSpec("velocity", "velocity", unit="rad/s", compared=True),
    "torque_command": SignalSpec("torque_command", "torque_command", unit="N.m", compared=True),
}


def columns(*cells: str) -> list[Column]:
    return [Column(name, np.zeros(1), unit) for name, unit in map(split_unit, cells)]


def guessed(*cells: str, signals: dict[str, SignalSpec] = AXIS) -> dict[str, str]:
    """Settled guesses, and questions with a mark."""
    found = guess_columns(signals, columns(*cells))
    return {name: "?".join(guess.columns) for name, guess in found.items()}


@pytest.mark.parametrize(
    ("reference", "position", "torque"),
    [
        ("SetPos [deg]", "ActPos [deg]", "ActTorque [Nm]"),
        ("soll", "ist_winkel", "moment"),
        ("Sollwinkel", "Istwinkel", "Drehmoment"),
        ("MAIN.fbAxis.fSetPos", "MAIN.fbAxis.fActPos", "MAIN.fbAxis.fTorque"),
        ("pos_cmd_deg", "pos_fb_deg", "trq_cmd_Nm"),
        ("axis0.controller.input_pos", "axis0.encoder.pos_estimate", "axis0.torque_setpoint"),
        ("q_ref", "q_meas", "tau_cmd"),
        ("target", "enc [deg]", "tau [mN.m]"),
    ],
)
def test_names_of_loggers_are_understood(reference: str, position: str, torque: str) -> None:
    names = {
        n: split_unit(cell)[0]
        for n, cell in zip(("r", "p", "t"), (reference, position, torque), strict=True)
    }
    expected = {"reference": names["r"], "position": names["p"], "torque_command": names["t"]}
    assert guessed(reference, position, torque) == expected
    # The order of the file says nothing.
    assert guessed(torque, position, reference) == expected


def test_the_signals_own_name_comes_first() -> None:
    found = guessed("reference", "position", "position_act", "torque_command", "torque")
    assert found == {name: name for name in ("reference", "position", "torque_command")}


def test_two_that_fit_as_well_are_a_question() -> None:
    assert guessed("enc1_act", "enc2_act") == {"position": "enc1_act?enc2_act"}


def test_a_column_in_another_quantity_is_never_guessed() -> None:
    assert guessed("position [V]", "reference [V]", "torque_command [rad]") == {}
    assert guessed("position [counts]") == {"position": "position"}  # it needs a scale


def test_a_set_point_is_no_measurement_nor_the_reverse() -> None:
    assert guessed("pos_set") == {"reference": "pos_set"}
    assert guessed("pos_act") == {"position": "pos_act"}
    assert guessed("angle") == {"position": "angle"}


@pytest.mark.parametrize("cell", ["list", "moist", "temperature", "note", "x7", "counter"])
def test_control_other_columns_are_not_guessed(cell: str) -> None:
    assert guessed(cell) == {}


@given(st.lists(st.sampled_from(
    ["SetPos", "ActPos", "pos", "ref", "w", "speed_rpm", "tau", "torque_act", "a.pos", "b.pos"]
), unique=True))  # fmt: skip
def test_no_column_is_guessed_twice_and_none_is_invented(cells: list[str]) -> None:
    found = guess_columns(AXIS, columns(*cells))
    settled = [guess.columns[0] for guess in found.values() if len(guess.columns) == 1]
    assert len(settled) == len(set(settled))
    assert set(settled) <= {*cells}
    for guess in found.values():
        if len(guess.columns) > 1:
            assert not set(guess.columns) & set(settled)
