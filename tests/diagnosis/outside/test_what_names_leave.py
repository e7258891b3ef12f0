"""How much right names may leave, and what a free function beside them has to take of it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.naming.decision import Decision
from gmfbo.diagnosis.outside import beyond_library
from gmfbo.diagnosis.screening.port_response import PortResponse
from gmfbo.physics import CATALOGUE

NOISE = 10_000.0
THRESHOLD = 30.0
RNG = np.random.default_rng(0)


def judged(left: float) -> Case:
    """A case of this chi2 with its names, under noise of 10 000."""
    found = SimpleNamespace(
        budget=SimpleNamespace(noise=NOISE), base=SimpleNamespace(chi2=left, residual=())
    )
    return cast(Case, found)


def named(*names: str) -> Decision:
    """A decision for these effects."""
    rounds = [
        SimpleNamespace(winner=SimpleNamespace(effect=SimpleNamespace(law=CATALOGUE[name])))
        for name in names
    ]
    return cast(
        Decision, SimpleNamespace(rounds=rounds, threshold=THRESHOLD, model=SimpleNamespace())
    )


@pytest.fixture
def uneven(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever is left is more in one motion than in another."""
    monkeypatch.setattr(beyond_library, "is_uneven", lambda *given: True)


@pytest.mark.usefixtures("uneven")
@pytest.mark.parametrize(
    ("name", "left", "too_much"),
    [
        ("coulomb_friction", 1.2 * NOISE, False),  # where an axis sticks is chance
        ("backlash", 1.2 * NOISE, False),
        ("coulomb_friction", 1.3 * NOISE, True),
        ("gravity_torque", 1.2 * NOISE, True),
        ("gravity_torque", 1.0 * NOISE, False),
    ],
)
def test_names_may_leave_noise_and_what_sticking_makes_of_it(
    name: str, left: float, too_much: bool
) -> None:
    before = 2.0 * NOISE
    assert beyond_library._leaves_too_much(judged(left), named(name), before, RNG) is too_much


@pytest.mark.usefixtures("uneven")
def test_names_may_leave_a_tenth_of_a_misfit_and_no_more() -> None:
    """No law is exact: of 50 times the noise, five times the noise are no other physics."""
    before = 50.0 * NOISE
    for left, too_much in ((5.8 * NOISE, False), (6.0 * NOISE, True)):
        assert (
            beyond_library._leaves_too_much(judged(left), named("gravity_torque"), before, RNG)
            is too_much
        )


def test_no_right_name_leaves_hundreds_of_times_the_noise(monkeypatch: pytest.MonkeyPatch) -> None:
    """Then it is not asked whether what is left follows the motion."""
    monkeypatch.setattr(beyond_library, "is_uneven", lambda *given: False)
    before = 3000.0 * NOISE
    for left, too_much in ((390.0 * NOISE, False), (410.0 * NOISE, True)):
        assert (
            beyond_library._leaves_too_much(judged(left), named("hysteresis"), before, RNG)
            is too_much
        )


@pytest.mark.parametrize(
    ("name", "beside", "left", "gained", "more"),
    [
        ("gravity_torque", 80.0, NOISE, 1000.0, False),  # three thresholds are 90
        ("gravity_torque", 100.0, NOISE, 1000.0, True),
        # A twentieth of what names gain, where no more is left; a hundredth of it, where more is.
        ("gravity_torque", 100.0, NOISE, 4000.0, False),
        ("gravity_torque", 100.0, NOISE + 1.0, 4000.0, True),
        # Beside friction, a quarter of the noise is still chance.
        ("coulomb_friction", 100.0, NOISE + 1.0, 4000.0, False),
        ("coulomb_friction", 1100.0, 1.24 * NOISE, 1e5, False),
        ("coulomb_friction", 1100.0, 1.26 * NOISE, 1e5, True),
        # Two fifths of what is left beyond noise.
        ("gravity_torque", 350.0, NOISE + 1000.0, 4000.0, False),
        ("gravity_torque", 450.0, NOISE + 1000.0, 4000.0, True),
    ],
)
def test_a_function_beside_names_has_to_take_much_of_what_they_leave(
    monkeypatch: pytest.MonkeyPatch,
    name: str,
    beside: float,
    left: float,
    gained: float,
    more: bool,
) -> None:
    family = SimpleNamespace(gain=beside, fall=2.0 * beside, family=SimpleNamespace(shared=True))
    monkeypatch.setattr(
        beyond_library, "unnamed", lambda *given: SimpleNamespace(families=(family,))
    )
    response = cast(PortResponse, SimpleNamespace())
    found = beyond_library._explains_more_beside(judged(left), named(name), gained, response, RNG)
    assert found is more


def test_the_sensors_port_is_asked_beside_an_error_of_the_sensor(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked = []

    response = cast(PortResponse, SimpleNamespace())

    def measured(case: Case, port: str, rng: np.random.Generator) -> PortResponse:
        asked.append(port)
        return response

    monkeypatch.setattr(beyond_library, "measure_port_response", measured)
    assert beyond_library._at_sensor(judged(NOISE), named("coulomb_friction"), RNG) == ()
    beside = beyond_library._at_sensor(judged(NOISE), named("sensor_eccentricity"), RNG)
    assert beside == (response,)
    assert asked == ["sensor"]


def test_what_passed_once_falls_to_a_function_of_a_state_that_explains_half_of_it() -> None:
    """A pulse alone does; beside a law that lasts it is asked like any other name."""
    assert beyond_library._passes_by(named("pulse_disturbance"))
    assert not beyond_library._passes_by(named("pulse_disturbance", "gravity_torque"))
