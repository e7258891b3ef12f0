"""Units as people write them become SI, and numbers with a unit are short."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.units import number, parse_unit, percent, quantity

# Values of one unit in SI, from the SI brochure and the definitions of rpm, inch and pound-force.
KNOWN = [
    ("N.m", 1.0, "N.m"),
    ("Nm", 1.0, "N.m"),
    ("N m", 1.0, "N.m"),
    ("N·m", 1.0, "N.m"),
    ("N*m", 1.0, "N.m"),
    ("mNm", 1e-3, "N.m"),
    ("mN.m", 1e-3, "N.m"),
    ("Ncm", 1e-2, "N.m"),
    ("kN", 1e3, "N"),
    ("deg", 0.017453292519943295, "rad"),
    ("°", 0.017453292519943295, "rad"),
    ("deg/s", 0.017453292519943295, "rad/s"),
    ("°/s²", 0.017453292519943295, "rad/s2"),
    ("mrad", 1e-3, "rad"),
    ("rpm", 0.10471975511965977, "rad/s"),
    ("rev/min", 0.10471975511965977, "rad/s"),
    ("rev", 6.283185307179586, "rad"),
    ("krpm", 104.71975511965977, "rad/s"),
    ("mm", 1e-3, "m"),
    ("um", 1e-6, "m"),
    ("µm", 1e-6, "m"),
    ("mm/s^2", 1e-3, "m/s2"),
    ("m/s/s", 1.0, "m/s2"),
    ("m.s-2", 1.0, "m/s2"),
    ("km/h", 1 / 3.6, "m/s"),
    ("mA", 1e-3, "A"),
    ("kV", 1e3, "V"),
    ("mOhm", 1e-3, "ohm"),
    ("per mille", 1e-3, "1"),
    ("‰", 1e-3, "1"),
    ("%", 1e-2, "1"),
    ("-", 1.0, "1"),
    ("ms", 1e-3, "s"),
    ("us", 1e-6, "s"),
    ("min", 60.0, "s"),
    ("g.cm2", 1e-7, "kg.m2"),
    ("kg·m²", 1.0, "kg.m2"),
    ("Nm/deg", 57.29577951308232, "N.m/rad"),
    ("N.m/(rad/s)", 1.0, "N.m.s/rad"),
    ("Nm/A", 1.0, "N.m/A"),
    ("in", 0.0254, "m"),
    ("lbf", 4.4482216152605, "N"),
    ("Grad", 0.017453292519943295, "rad"),
    ("Grad/s", 0.017453292519943295, "rad/s"),
    ("Umdr/min", 0.10471975511965977, "rad/s"),
    ("Millisekunden", 1e-3, "s"),
    ("gon", 0.015707963267948967, "rad"),
    ("Gradian", 0.015707963267948967, "rad"),
    ("counts", 1.0, "counts"),
    ("inc", 1.0, "counts"),
]


@pytest.mark.parametrize(("text", "value", "si"), KNOWN)
def test_one_unit_has_its_si_value_and_spelling(text: str, value: float, si: str) -> None:
    unit = parse_unit(text)
    assert unit is not None
    assert unit.si == si
    assert unit.to_si(np.array([1.0]))[0] == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(("text", "kelvins"), [("degC", 293.15), ("°C", 293.15), ("K", 20.0)])
def test_twenty_degrees_in_kelvins(text: str, kelvins: float) -> None:
    unit = parse_unit(text)
    assert unit is not None
    assert unit.to_si(np.array([20.0]))[0] == pytest.approx(kelvins)


@pytest.mark.parametrize(
    "text", ["", "foo", "N.", "(N", "N)", "PS", "rad//s", "/s", "m^99", "µ", "grad"]
)
def test_what_is_no_unit_is_not_guessed(text: str) -> None:
    assert parse_unit(text) is None


@pytest.mark.parametrize("other", ["1/s", "Hz", "1/min", "rad", "rad/s2", "m/s", "counts"])
def test_speed_of_rotation_is_not_confused_with(other: str) -> None:
    speed, unit = parse_unit("rad/s"), parse_unit(other)
    assert speed is not None
    assert unit is not None
    assert unit.dimension != speed.dimension


def test_a_joule_is_a_newton_metre() -> None:
    joule, torque = parse_unit("J"), parse_unit("N.m")
    assert joule is not None
    assert torque is not None
    assert joule.dimension == torque.dimension


@given(st.integers(-(10**9), 10**9))
def test_milliseconds_become_the_nearest_number_of_seconds(milliseconds: int) -> None:
    unit = parse_unit("ms")
    assert unit is not None
    assert unit.to_si(np.array([float(milliseconds)]))[0] == milliseconds / 1000


@given(
    st.sampled_from(["N", "m", "s", "A", "V", "rad", "Pa", "W"]),
    st.sampled_from(["", "k", "m", "u"]),
    st.integers(1, 3),
)
def test_a_power_of_a_unit_has_the_power_of_its_value(symbol: str, prefix: str, power: int) -> None:
    one, many = parse_unit(prefix + symbol), parse_unit(f"{prefix}{symbol}{power}")
    assert one is not None
    assert many is not None
    assert many.factor == one.factor**power
    assert many.dimension == tuple(power * exponent for exponent in one.dimension)


@given(st.sampled_from([text for text, _, _ in KNOWN]))
def test_the_si_spelling_is_understood_as_itself(text: str) -> None:
    unit = parse_unit(text)
    assert unit is not None
    again = parse_unit(unit.si)
    assert again is not None
    assert (again.si, again.is_si) == (unit.si, True)
    assert again.dimension == unit.dimension


@given(st.text(max_size=12))
def test_any_text_is_a_unit_or_none(text: str) -> None:
    unit = parse_unit(text)
    assert unit is None or math.isfinite(float(unit.factor))


@pytest.mark.parametrize(
    ("value", "unit", "words"),
    [
        (0.5193, "N.m", "0.52 N m"),
        (0.0021, "s", "2.1 ms"),
        (8e-4, "rad", "0.8 mrad"),
        (-0.0421, "N.m", "-0.042 N m"),
        (20.4, "N", "20 N"),
        (0.031, "N.m/(rad/s)", "0.031 N m/(rad/s)"),
        (12.3, "1", "12.3"),
        (0.0, "s", "0 s"),
    ],
)
def test_quantities_are_short(value: float, unit: str, words: str) -> None:
    assert quantity(value, unit) == words


def test_shares_are_percentages() -> None:
    assert percent(0.0423) == "4.2 %"


@given(st.floats(1e-12, 1e12))
def test_numbers_keep_their_first_digits(value: float) -> None:
    assert float(number(value)) == pytest.approx(value, rel=0.06)
