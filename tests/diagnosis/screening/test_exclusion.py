"""Effects and parameters that the user rules out, by name or shell pattern."""

from __future__ import annotations

import pytest

from gmfbo import FmuTwin, diagnose
from gmfbo.diagnosis.screening.exclusion import check_assumed, excluded
from gmfbo.errors import InputError
from gmfbo.physics import CATALOGUE
from tests.diagnosis.short_recordings import SERVO, multisine


@pytest.fixture(scope="module")
def twin() -> FmuTwin:
    return SERVO.twin()


def test_effects_and_parameters_are_told_apart(twin: FmuTwin) -> None:
    found = excluded(twin.binding, ["backlash", "inert*", "viscous"])
    assert found.effects == ("backlash",)
    assert found.parameters == ("inertia", "viscous")
    assert excluded(twin.binding, []).parameters == ()


def test_excluded_parameter_is_certain_in_the_diagnosis_alone(twin: FmuTwin) -> None:
    held = excluded(twin.binding, ["inertia"]).held_in(twin)
    assert set(held.file.uncertain) == {"viscous"}
    assert set(twin.file.uncertain) == {"inertia", "viscous"}
    assert excluded(twin.binding, ["backlash", "kp"]).held_in(twin) is twin


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("Backlash", "did you mean 'backlash'"),
        ("inertai", "did you mean 'inertia'"),
        ("nothing.*", "no effect 'nothing.*' to exclude, and no parameter of the twin matches it"),
        ("position", "no parameter of the twin matches it"),
    ],
)
def test_what_matches_nothing_is_refused_with_the_nearest(
    twin: FmuTwin, name: str, said: str
) -> None:
    with pytest.raises(InputError) as refused:
        excluded(twin.binding, [name])
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_parameter_is_not_assumed(twin: FmuTwin) -> None:
    with pytest.raises(InputError, match="'inertia' is a parameter of the twin; only effects"):
        check_assumed(twin.binding, ["backlash", "inertia"])
    with pytest.raises(InputError, match=r"no effect 'inert\*' to assume"):
        check_assumed(twin.binding, ["inert*"])
    check_assumed(twin.binding, ["backlash"])


def test_an_excluded_parameter_keeps_its_value(twin: FmuTwin) -> None:
    """Without it both are estimated: see test_kinds_of_twins.py, of the same axis."""
    others = [name for name in CATALOGUE if name != "backlash"]
    recordings = SERVO.recordings({}, (multisine,), seconds=0.7)
    held = diagnose(twin, recordings, exclude=[*others, "visc*"], jobs=1)
    assert set(held.parameters) == {"inertia"}
    assert set(twin.file.uncertain) == {"inertia", "viscous"}
