"""Of two limits that a few stretches show, the one that explains more of them is chosen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gmfbo.diagnosis.naming.conditions import simplest
from gmfbo.diagnosis.naming.decision import Evidence
from tests.diagnosis.naming.linear_evidences import WINDOWS, direction, evidence_of

THRESHOLD = 30.0
BEFORE = 40.0 * direction(1)


def shown(name: str, gain: float, chi2: float) -> Evidence:
    """One effect with a gain on what was left out, and what it leaves of all."""
    residual = np.sqrt(chi2) * direction(1)
    evidence = evidence_of(name, residual, BEFORE)
    return replace(evidence, gains=np.full(WINDOWS, gain / WINDOWS))


def test_a_limit_that_one_stretch_shows_is_chosen_by_what_it_leaves() -> None:
    saturation, rate = (
        shown("actuator_saturation", 89.0, 800.0),
        shown("actuator_rate_limit", 429.0, 1125.0),
    )
    assert simplest([saturation, rate], THRESHOLD, 0.0) is saturation


def test_between_a_limit_and_another_law_what_was_left_out_decides() -> None:
    saturation, pulse = (
        shown("actuator_saturation", 400.0, 950.0),
        shown("pulse_disturbance", 89.0, 800.0),
    )
    assert simplest([saturation, pulse], THRESHOLD, 0.0) is saturation


def test_laws_that_are_no_limits_are_chosen_by_what_was_left_out() -> None:
    friction, cogging = (
        shown("coulomb_friction", 429.0, 1125.0),
        shown("cogging_torque", 89.0, 800.0),
    )
    assert simplest([friction, cogging], THRESHOLD, 0.0) is friction


def test_a_law_without_a_clock_is_preferred_to_a_pulse_that_explains_little_more() -> None:
    """That a push came just where a supply would fail is no chance; far from all of it may be."""
    pulse = shown("pulse_disturbance", 400.0, 800.0)
    nearly, hardly = (shown("supply_voltage_limit", gain, 1200.0 - gain) for gain in (370.0, 300.0))
    assert simplest([nearly, pulse], THRESHOLD, 0.0) is nearly
    assert simplest([hardly, pulse], THRESHOLD, 0.0) is pulse
