"""How much speed a blow of the flanks returns is found beside the gap, though it is not fitted."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace

import pytest

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.fit import fit
from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.diagnosis.naming.candidate_fits import confirm
from gmfbo.physics import CATALOGUE, Excitation, Values
from tests.diagnosis.servo_recordings import HIDDEN, hidden_servo, opened_with

pytestmark = pytest.mark.slow

LAW = CATALOGUE["backlash"]
GAP, LOAD = 4e-3, 0.004
MOTOR = HIDDEN["inertia"] - LOAD


def contacts(excitation: Excitation) -> list[Values]:
    """Dead blows, and blows that return half of the speed."""
    return [LAW.fixed(excitation), LAW.fixed_otherwise(excitation)[0]]


@pytest.fixture
def excitation(right_case: Case) -> Excitation:
    """What the recordings of a rigid axis show."""
    return right_case.setting.excitation


def with_gap(contact: Values) -> Case:
    """Open the case of an axis with free play and this contact, of which its twin knows nothing."""
    values = {"gap": GAP, "load_inertia": LOAD, "shaft_inertia": MOTOR, **contact}
    physics = {f"backlash.{name}": value for name, value in values.items()}
    return opened_with(*hidden_servo(physics, parameters={"inertia": MOTOR}))


@pytest.mark.parametrize(("hidden", "other"), [pytest.param(0, 1, marks=pytest.mark.slow), (1, 0)])
def test_the_contact_is_chosen_with_the_fit(
    excitation: Excitation, hidden: int, other: int
) -> None:
    with closing((case := with_gap(contacts(excitation)[hidden])).simulations):
        start = Candidate("backlash", LAW.starts(excitation)[2])
        (found,) = confirm(case.misfit, case.base, [start])
        effect = found.hypothesis.effects[0]
        choices = contacts(case.setting.excitation)
        chosen = {**LAW.fixed(case.setting.excitation), **effect.more}
        assert chosen["damping"] == pytest.approx(choices[hidden]["damping"])
        assert effect.values["gap"] == pytest.approx(GAP, rel=0.05)
        assert effect.values["load_inertia"] == pytest.approx(LOAD, rel=0.06)
        # A negative control: with the other contact the best fit from there leaves more.
        wrong = replace(found.hypothesis, effects=(replace(effect, more=choices[other]),))
        left = fit(case.misfit, wrong, found.parameters)
        assert left is not None
        assert left.chi2 > 1.2 * found.chi2
