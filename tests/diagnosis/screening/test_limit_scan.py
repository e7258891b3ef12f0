"""Limits that cut for a few milliseconds begin at the size that the recorded command tells."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pytest

from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.diagnosis.naming.candidate_fits import confirm
from gmfbo.diagnosis.screening import limit_scan
from gmfbo.diagnosis.screening.limit_scan import scan_limits
from gmfbo.physics import CATALOGUE, States
from tests.diagnosis.noise.planted_noise import opened, planted

LIMITS = ("actuator_saturation", "supply_voltage_limit")
LEAST = 30.0
SIGMA = 3e-5


def scanned(
    physics: Mapping[str, float], names: Sequence[str] = LIMITS
) -> tuple[list[tuple[float, Candidate]], list[Candidate], int]:
    """What the scan finds, what fits from there on, and the rows in which the limit cuts."""
    found = planted(SIGMA, physics)
    limit = physics.get("actuator_saturation.limit", np.inf)
    rows = sum(
        int(np.count_nonzero(np.abs(r.signal("torque_command")) > limit)) for r in found.recordings
    )
    with opened(found) as case:
        scan = scan_limits(case, case.base, np.random.default_rng(0), names, LEAST)
        fits = confirm(case.misfit, case.base, [candidate for _, candidate in scan])
        return scan, [fitted.hypothesis.effects[0] for fitted in fits], rows


@pytest.mark.parametrize(
    ("limit", "scan_within", "rows_at_most"), [(1.2, 0.05, 90), (1.3, 0.01, 40)]
)
def test_a_saturation_of_a_few_ms_is_found_and_fits_at_its_size(
    limit: float, scan_within: float, rows_at_most: int
) -> None:
    """The command of 2.8 s passes the limit in 76 and in 32 rows of 1 ms."""
    scan, fits, rows = scanned({"actuator_saturation.limit": limit}, LIMITS[:1])
    assert 10 < rows < rows_at_most
    ((gain, start),) = scan
    assert start.effect == "actuator_saturation"
    assert gain > 10.0 * LEAST
    assert start.values["limit"] == pytest.approx(limit, rel=scan_within)
    assert fits[0].values["limit"] == pytest.approx(limit, rel=0.005)


def test_a_rate_limit_within_a_row_is_found_by_the_jumps_of_the_command() -> None:
    """The command jumps by at most 0.23 N m a row of 1 ms, which takes 1.5 rows at 150 N m/s."""
    ((gain, start),), (fitted,), _ = scanned(
        {"actuator_rate_limit.rate": 150.0}, ("actuator_rate_limit",)
    )
    assert gain > LEAST
    assert start.values["rate"] == pytest.approx(150.0, rel=0.15)
    assert fitted.values["rate"] == pytest.approx(150.0, rel=0.04)


@pytest.mark.slow
def test_a_rate_limit_that_the_fastest_command_hardly_passes_is_found() -> None:
    """The command changes by at most 160 N m/s, but for steps within a row: their means tell."""
    ((gain, start),), (fitted,), _ = scanned(
        {"actuator_rate_limit.rate": 205.0}, ("actuator_rate_limit",)
    )
    assert gain > LEAST
    assert start.values["rate"] == pytest.approx(205.0, rel=0.25)
    assert fitted.values["rate"] == pytest.approx(205.0, rel=0.1)


def test_what_a_rate_limit_takes_off_a_row_is_the_mean_of_its_line() -> None:
    """One jump of 3 at 2000 a second: rows of 1 ms start 3 and 1 behind, and end 1 and 0 behind."""
    time = 1e-3 * np.arange(6.0)
    command = np.array([0.0, 0.0, 3.0, 3.0, 3.0, 3.0])
    still = np.zeros(6)
    states = States(time, still, still, command, command)
    signal = CATALOGUE["actuator_rate_limit"].signal
    assert signal is not None
    behind = signal(states, {"rate": 2000.0})
    np.testing.assert_allclose(
        limit_scan.over_rows(states, behind, 2000.0), [0.0, 0.0, -2.0, -0.25, 0.0, 0.0]
    )


def test_a_supply_limit_far_from_the_grid_is_found() -> None:
    physics = {"supply_voltage_limit.limit": 1.8, "supply_voltage_limit.slope": 0.25}
    ((_, start),), (fitted,), _ = scanned(physics, LIMITS[1:])
    assert start.values["slope"] == pytest.approx(0.25, rel=0.15)
    assert fitted.values["limit"] == pytest.approx(1.8, rel=0.01)


def test_a_dead_zone_begins_at_its_width() -> None:
    ((_, start),), (fitted,), _ = scanned(
        {"actuator_dead_zone.width": 0.02}, ("actuator_dead_zone",)
    )
    assert start.values["width"] == pytest.approx(0.02, rel=0.05)
    assert fitted.values["width"] == pytest.approx(0.02, rel=0.05)


@pytest.mark.slow
def test_of_two_limits_the_one_that_gains_most_comes_first() -> None:
    scan, _, _ = scanned({"actuator_saturation.limit": 1.2})
    assert [candidate.effect for _, candidate in scan] == list(LIMITS)
    assert scan[0][0] > scan[1][0]


def test_where_nothing_cuts_no_size_is_worth_a_fit() -> None:
    scan, fits, _ = scanned({})
    assert (scan, fits) == ([], [])


def test_limits_that_may_not_be_tried_are_not() -> None:
    assert scanned({"actuator_saturation.limit": 1.2}, ("coulomb_friction",))[0] == []


@pytest.mark.slow
def test_a_supply_limit_begins_between_the_sizes_of_the_grid(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    physics = {"supply_voltage_limit.limit": 1.45, "supply_voltage_limit.slope": 0.08}
    ((_, start),), (fitted,), _ = scanned(physics, LIMITS[1:])
    assert start.values["slope"] == pytest.approx(0.08, rel=0.2)
    assert fitted.values["limit"] == pytest.approx(1.45, rel=0.005)
    monkeypatch.setattr(limit_scan, "_refined", lambda gain, size: dict(size))
    ((_, coarse),), _, _ = scanned(physics, LIMITS[1:])  # negative control
    assert coarse.values["slope"] < 0.5 * 0.08
