"""What was found later tells rivals from the effect that came first."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.diagnosis.naming.candidate_fits import confirm
from gmfbo.diagnosis.naming.conditions import _is_where_friction_held
from gmfbo.diagnosis.naming.decision import Decision, Evidence
from gmfbo.diagnosis.naming.rivals import rivals_beside
from gmfbo.diagnosis.screening.testable_effects import candidates
from tests.diagnosis.port_cases import open_servo

pytestmark = pytest.mark.slow

HIDDEN = {"coulomb_friction.level": 0.05, "gravity_torque.sine": 0.1}


@pytest.fixture(scope="module")
def case() -> Iterator[Case]:
    found = open_servo(HIDDEN)
    yield found
    found.simulations.close()


def fitted(case: Case, model: Fitted, name: str) -> Fitted:
    return confirm(case.misfit, model, starts(case, name))[0]


def starts(case: Case, name: str) -> list[Candidate]:
    return candidates([name], case.setting.excitation)[:1]


def evidence(fit: Fitted, signature: list[float] | None = None) -> Evidence:
    shown = np.array(signature or [0.0])
    return Evidence(fit, shown, shown, fit.chi2)


def test_what_does_not_do_as_well_beside_the_rest_is_no_rival(case: Case) -> None:
    """A spring cannot stand for friction where gravity is known, whatever it did alone."""
    friction = fitted(case, case.base, "coulomb_friction")
    both = fitted(case, friction, "gravity_torque")
    alone = [fitted(case, case.base, n) for n in ("gravity_torque", "elastic_return")]
    assert rivals_beside(case, both, 0, [evidence(fit) for fit in alone]) == ()


def test_what_does_as_well_beside_the_rest_stays_a_rival(case: Case) -> None:
    """Stribeck friction without a rise is Coulomb friction, beside gravity too."""
    friction = fitted(case, case.base, "coulomb_friction")
    both = fitted(case, friction, "gravity_torque")
    (kept,) = rivals_beside(case, both, 0, [evidence(fitted(case, case.base, "stribeck_friction"))])
    assert kept.name == "stribeck_friction"


@pytest.mark.parametrize(("later", "held"), [(2.0, True), (50.0, False)])
def test_an_offset_that_shows_only_where_friction_held_the_axis_is_none(
    case: Case, later: float, held: bool
) -> None:
    """Two recordings of two stretches: the first ones hold what the offset explains, or all do."""
    windows = [SimpleNamespace(record=k) for k in (0, 0, 1, 1)]
    stretches = cast(Case, SimpleNamespace(budget=SimpleNamespace(windows=windows)))
    friction = fitted(case, case.base, "coulomb_friction")
    offset = evidence(fitted(case, friction, "sensor_offset"), [100.0, later, 60.0, later])
    assert _is_where_friction_held(stretches, offset, Decision(model=friction)) is held
    # Where nothing holds the axis, how recordings begin tells of the sensor.
    assert not _is_where_friction_held(stretches, offset, Decision(model=case.base))


def test_recordings_of_one_stretch_do_not_tell_whether_an_offset_lasts(case: Case) -> None:
    friction = fitted(case, case.base, "coulomb_friction")
    offset = evidence(fitted(case, friction, "sensor_offset"), [100.0] * len(case.budget.windows))
    assert not _is_where_friction_held(case, offset, Decision(model=friction))
