"""Marked numbers: they read back as what they were, in prefixes that read well."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.diagnosis.page.effect_account import law_html
from gmfbo.pages.marked_number import (
    json_path,
    marked_interval,
    marked_number,
    marked_percent,
    scale_for,
    unit_text,
)
from tests.pages.page_text import PageText, at_path, rounds_to

numbers = st.floats(-1e12, 1e12).filter(lambda value: value == 0.0 or abs(value) > 1e-12)
units = st.sampled_from(["N.m", "rad", "s", "kg.m2", "1", "", "N.m/(rad/s)", "m", "1/rad"])


@given(value=numbers, unit=units, digits=st.integers(2, 6), sign=st.sampled_from([1.0, -1.0]))
def test_a_number_reads_back_as_what_it_was(
    value: float, unit: str, digits: int, sign: float
) -> None:
    factor = sign * scale_for(value, unit).factor
    (number,) = PageText(marked_number(("x",), value, factor=factor, digits=digits)).numbers
    assert rounds_to(number, value)
    if value:
        told = float(number.shown.replace("\u202f", "")) * number.scale
        assert told == pytest.approx(value, rel=0.51 * 10.0 ** (1 - digits))


@given(value=numbers, half=st.floats(1e-9, 1e9), unit=units)
def test_an_interval_reads_back_to_a_sixth_of_its_width(
    value: float, half: float, unit: str
) -> None:
    low, high = value - half, value + half
    shown = PageText(marked_interval(("x",), value, low, high, unit).text).numbers
    for number, one in zip(shown, (value, low, high), strict=True):
        assert rounds_to(number, one)
        off = abs(float(number.shown) * number.scale - one)
        assert off <= max(half / 6.0, 6e-4 * abs(one))


@pytest.mark.parametrize(
    ("value", "unit", "factor", "shown"),
    [
        (0.00032, "rad", 1e-6, "µrad"),
        (0.0023, "rad", 1e-3, "mrad"),
        (0.05, "N.m", 1.0, "N\u00a0m"),
        (0.0005, "N.m", 1e-6, "µN\u00a0m"),
        (25_000.0, "N/m", 1e3, "kN/m"),
        (0.00001, "kg.m2", 1.0, "kg\u00a0m²"),
        (0.001, "1/rad", 1.0, "1/rad"),
        (0.0, "s", 1.0, "s"),
        (math.nan, "s", 1.0, "s"),
    ],
)
def test_prefixes_are_those_that_an_engineer_would_write(
    value: float, unit: str, factor: float, shown: str
) -> None:
    scale = scale_for(value, unit)
    assert (scale.factor, scale.unit) == (factor, shown)


def test_a_share_is_told_in_per_cent() -> None:
    scale = scale_for(0.08, "1", share=True)
    assert (scale.factor, scale.unit) == (0.01, "%")
    assert marked_percent(("x",), 0.306) == '<data data-path="x" data-scale="0.01">31</data>\u00a0%'


def test_what_is_not_there_is_a_dash() -> None:
    for text in (marked_number(("x",), math.nan), marked_percent(("x",), math.nan)):
        (number,) = PageText(text).numbers
        assert number.shown == "-"
        assert rounds_to(number, None)


@given(names=st.lists(st.text(min_size=1).filter(lambda n: not n.isdigit()), min_size=1))
def test_a_place_is_found_again_whatever_its_names(names: list[str]) -> None:
    content: object = 7
    for name in reversed(names):
        content = {name: content}
    assert at_path(content, json_path(names)) == 7


def test_units_and_laws_are_set_as_by_hand() -> None:
    assert unit_text("N.m.s2/rad2") == "N\u00a0m\u00a0s²/rad²"
    assert law_html("tau = -F_c * sign(omega)") == "τ = −F<sub>c</sub>\u202f·\u202fsign(ω)"
    assert law_html("exp(-(omega/omega_s)^2)") == "exp(−(ω/ω<sub>s</sub>)<sup>2</sup>)"
    assert law_html("<b>") == "&lt;b&gt;"
