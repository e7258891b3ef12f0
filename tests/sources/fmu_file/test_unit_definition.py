"""Units that an FMU defines come before gmfbo's table; a definition that says less does not."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

from gmfbo.sources.fmu_file.unit_definition import fmu_unit

G = 9.80665


@pytest.mark.parametrize(
    ("name", "definition", "si", "factor"),
    [
        ("1/min", {"rad": 1, "s": -1, "factor": math.pi / 30}, "rad/s", math.pi / 30),
        ("g", {"m": 1, "s": -2, "factor": G}, "m/s2", G),
        ("Nm", {"kg": 1, "m": 1, "s": -2}, "N", 1.0),
        ("mm", {"m": 1, "factor": 1e-2}, "m", 1e-2),
        ("gee", {"m": 1, "s": -2, "factor": G}, "m/s2", G),
        ("ozin", {"kg": 1, "m": 2, "s": -2, "factor": 7.0615e-3}, "N.m", 7.0615e-3),
    ],
)
def test_the_definition_counts_where_it_says_something_else(
    name: str, definition: dict[str, float], si: str, factor: float
) -> None:
    found = fmu_unit(name, SimpleNamespace(**definition))
    assert (found.si, found.zero) == (si, 0.0)
    assert found.factor == pytest.approx(factor)


@pytest.mark.parametrize(
    ("name", "definition"),
    [
        ("rpm", {"s": -1, "factor": 0.10472}),
        ("rpm", {"s": -1, "factor": 1 / 60}),
        ("rad/s", {"s": -1}),
        ("rad/s", {}),
        ("deg", {"factor": 0.017453}),
        ("deg", {}),
        ("degC", {"K": 1, "offset": 273.15}),
        ("N.m/rad", {"kg": 1, "m": 2, "s": -2}),
        ("%", {"factor": 0.01}),
    ],
)
def test_the_table_counts_where_the_definition_leaves_out_the_angle_or_digits(
    name: str, definition: dict[str, float]
) -> None:
    assert fmu_unit(name, SimpleNamespace(**definition)) == fmu_unit(name, None)


def test_a_name_that_nobody_knows_is_kept() -> None:
    assert fmu_unit("widgets", None) == ("widgets", 1.0, 0.0)
    assert fmu_unit("", None) == ("", 1.0, 0.0)
    assert fmu_unit("lm", SimpleNamespace(cd=1, factor=2.0)) == ("lm", 2.0, 0.0)
