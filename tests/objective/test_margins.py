"""Margins from a frequency response: closed forms, python-control, and limits on them."""

from __future__ import annotations

import control
import numpy as np
import pytest

from gmfbo.objective.limits import Limits
from gmfbo.objective.margins import MOST_FACTOR, margins

FREQUENCY = np.geomspace(1e-3, 30.0, 80)
S = 2j * np.pi * FREQUENCY


def test_margins_of_a_third_order_loop_are_the_closed_forms() -> None:
    found = margins(FREQUENCY, 2.0 / (S + 1.0) ** 3)  # |L| is 2 / 8 where the phase is -180 deg
    assert found["gain_margin"] == pytest.approx(4.0, rel=1e-4)
    crossing = np.sqrt(2.0 ** (2.0 / 3.0) - 1.0)
    expected = 180.0 - 3.0 * np.degrees(np.arctan(crossing))
    assert found["phase_margin"] == pytest.approx(expected, abs=0.01)


def test_a_loop_that_never_turns_round_has_no_gain_margin_to_lose() -> None:
    found = margins(FREQUENCY, 0.5 / (S + 1.0))
    assert (found["phase_margin"], found["gain_margin"]) == (180.0, MOST_FACTOR)
    assert found["ms"] <= 1.0


@pytest.mark.parametrize("gain", [0.5, 3.0, 7.0])
def test_margins_are_those_of_python_control(gain: float) -> None:
    loop = control.tf([gain], [1.0, 1.0, 0.0]) * control.tf([1.0], [0.1, 1.0])
    factor, phase, distance, *_ = control.stability_margins(loop)
    found = margins(FREQUENCY, gain / (S * (S + 1.0) * (0.1 * S + 1.0)))
    assert found["gain_margin"] == pytest.approx(factor, rel=2e-3)
    assert found["phase_margin"] == pytest.approx(phase, abs=0.05)
    assert found["ms"] == pytest.approx(1.0 / distance, rel=2e-3)


def test_more_margin_is_better_and_less_sensitivity() -> None:
    limits = Limits({"phase_margin": 45.0, "ms": 1.8})
    assert limits.met({"phase_margin": 60.0, "ms": 1.5})
    assert not limits.met({"phase_margin": 30.0, "ms": 1.5})
    assert not limits.met({"phase_margin": 60.0, "ms": 2.0})
    assert limits.excess({"phase_margin": 22.5, "ms": 1.0}) == pytest.approx(0.5)


def test_a_limit_on_what_was_not_measured_is_not_met() -> None:
    assert not Limits({"phase_margin": 45.0}).met({"overshoot": 1.0})
