"""Units of parameters follow from those of the twin."""

from __future__ import annotations

import pytest

from gmfbo.errors import InputError
from gmfbo.physics import CATALOGUE, Units
from gmfbo.units import parse_unit

ROTARY = Units(command="V", current="A", load="A")
SLIDE = Units(torque="N", position="m", velocity="m/s", command="N", current="N", load="N")


@pytest.mark.parametrize(
    ("expression", "rotary", "linear"),
    [
        ("torque", "N.m", "N"),
        ("torque/velocity", "N.m/(rad/s)", "N/(m/s)"),
        ("torque/velocity2", "N.m/(rad2/s2)", "N/(m2/s2)"),
        ("torque/position", "N.m/rad", "N/m"),
        ("torque/current", "N.m/A", "1"),
        ("1/position", "1/rad", "1/m"),
        ("1/command", "1/V", "1/N"),
        ("command/s", "V/s", "N/s"),
        ("command/velocity", "V/(rad/s)", "N/(m/s)"),
        ("inertia", "kg.m2", "kg"),
        ("s", "s", "s"),
        ("Hz", "Hz", "Hz"),
        ("1", "1", "1"),
    ],
)
def test_an_expression_reads_in_the_twins_units(expression: str, rotary: str, linear: str) -> None:
    assert ROTARY.resolve(expression) == rotary
    assert SLIDE.resolve(expression) == linear


def test_an_inertia_without_a_name_of_its_own_is_a_ratio() -> None:
    assert Units(torque="V").resolve("inertia") == "V/(rad/s2)"


def test_every_unit_of_the_catalogue_is_one_that_recordings_understand() -> None:
    for effect in CATALOGUE.values():
        for expression in (*(p.unit for p in effect.parameters), effect.size_unit):
            for units in (ROTARY, SLIDE):
                assert parse_unit(units.resolve(expression)) is not None, expression


def test_an_unknown_word_is_refused() -> None:
    with pytest.raises(InputError, match=r"no unit 'torqe'; did you mean 'torque'"):
        ROTARY.resolve("torqe/velocity")
