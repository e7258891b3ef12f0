"""Times are written as a person writes them."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.plain_words import duration

_UNITS = {"us": 1e-6, "ms": 1e-3, "s": 1.0, "min": 60.0, "h": 3600.0}


@pytest.mark.parametrize(
    ("seconds", "said"),
    [
        (8.18, "8.18 s"),
        (0.25, "250 ms"),
        (1e-3, "1 ms"),
        (0.9996, "1 s"),
        (9.996e-4, "1 ms"),
        (2.5e-5, "25 us"),
        (0.0, "0 s"),
        (119.4, "119 s"),
        (125.2, "2 min 5 s"),
        (180.0, "3 min"),
        (8180.0, "2 h 16 min"),
        (7199.9, "2 h"),
        (-0.0021, "-2.1 ms"),
        (float("nan"), "-"),
    ],
)
def test_a_time_is_told_in_the_unit_that_a_person_takes(seconds: float, said: str) -> None:
    assert duration(seconds) == said


@given(st.floats(1e-6, 1e6))
def test_what_is_said_is_the_time_within_its_digits(seconds: float) -> None:
    said = duration(seconds)
    assert re.fullmatch(r"\d+(\.\d+)? (us|ms|s)|\d+ min( \d+ s)?|\d+ h( \d+ min)?", said)
    parts = said.split()
    told = sum(float(n) * _UNITS[unit] for n, unit in zip(parts[::2], parts[1::2], strict=True))
    assert told == pytest.approx(seconds, rel=8.4e-3)
