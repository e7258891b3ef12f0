"""Noise that a controller read is found in its recordings, and playing it mends a dead zone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo import FmuTwin
from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.hearing.sensed_noise import UnheardNoise, sensed_noise
from gmfbo.diagnosis.comparison.modes.posterior_mode import ModeSearch
from gmfbo.diagnosis.comparison.opened_comparison import comparison_of
from gmfbo.diagnosis.comparison.unknown.kinds import kinds
from gmfbo.diagnosis.runs.simulated import PlayedNoise
from tests.diagnosis.noise.planted_noise import Planted, opened, planted, servo_without_sensor

Array = NDArray[np.float64]
SIGMA = 3e-4  # [rad]


def sensed(case: Case) -> tuple[PlayedNoise, ...]:
    search = (stated := comparison_of(case, [])).search
    ledger = search.opened(stated.first)
    row, kernels, levels = ledger.rows[frozenset()], ledger.kernels, ledger.levels
    left = ledger.errors.taken_out(search.problem, row, kernels, levels)
    return sensed_noise(search.problem, left, kernels, levels)


def test_planted_noise_is_told() -> None:
    found = planted(SIGMA)
    with opened(found) as case:
        noise = sensed(case)
    for own, truth in zip(noise, found.noise, strict=True):
        inner = slice(50, -50)
        assert float(np.std((own.at_port - truth)[inner])) < 0.4 * SIGMA


def test_what_is_told_of_the_noise_and_what_is_not_make_it_up_together() -> None:
    """The law of total variance; of the truth, errors of the fit hide a little more."""
    found = planted(SIGMA)
    with opened(found) as case:
        search = (stated := comparison_of(case, [])).search
        ledger = search.opened(stated.first)
        row, about = ledger.rows[frozenset()], (ledger.kernels, ledger.levels)
        left = ledger.errors.taken_out(search.problem, row, *about)
        told = sensed_noise(search.problem, left, *about)
        drawn = UnheardNoise(search.problem, row, *about).drawn(np.random.default_rng(7))
    level = ledger.levels.ports["sensor"]
    inner = slice(50, -50)
    for own, rest, truth in zip(told, drawn, found.noise, strict=True):
        whole = np.var(own.at_port[inner]) + np.var(rest[inner])
        assert float(np.sqrt(whole)) == pytest.approx(level, rel=0.1)
        missed = float(np.std((own.at_port - truth)[inner]))
        assert 0.3 * missed < float(np.std(rest[inner])) < missed


def test_noise_that_the_logger_alone_saw_is_not_played() -> None:
    found = planted(SIGMA, is_felt=False)
    with opened(found) as case:
        noise = sensed(case)
    assert max(float(np.std(own.at_port)) for own in noise) < 0.2 * SIGMA


def test_without_a_sensor_port_it_is_told_as_the_torque_that_the_controller_makes_of_it(
    tmp_path: Path,
) -> None:
    found = planted(SIGMA)
    twin = FmuTwin(servo_without_sensor(tmp_path), isolated=False)
    with opened(replace(found, twin=twin)) as case:
        noise = sensed(case)
        search = (stated := comparison_of(case, [])).search
        kernels = search.kernels_at(stated.first)
        free = kinds(search.problem, kernels, stated.first)
    assert {kind.port for kind in free} == {"torque", "command"}
    for k, (own, truth) in enumerate(zip(noise, found.noise, strict=True)):
        ((port, torque),) = kernels.of(k).sensed(truth).items()
        inner = slice(50, -50)
        assert own.port == port == "torque"
        assert float(np.std((own.at_port - torque)[inner])) < 0.4 * float(np.std(torque[inner]))


WIDTH = 0.06  # [N m] of the command
DEAD_ZONE = {"actuator_dead_zone.width": WIDTH}


@pytest.mark.slow
def test_a_dead_zone_is_as_wide_as_it_is_where_noise_bridges_it() -> None:
    """A quiet twin needs a narrower one to move as easily: the control."""
    found: Planted = planted(SIGMA / 2.0, DEAD_ZONE)
    with opened(found) as case:
        stated = comparison_of(case, ["actuator_dead_zone"])
        search = stated.search
        ledger, scored = stated.run()
        heard = ledger.rows[scored.best]
        hushed = ModeSearch(search.problem, ledger.whitening, heard.hypothesis)
        quiet = hushed.again(heard)
    assert scored.best == {"actuator_dead_zone"}
    assert width(heard) == pytest.approx(WIDTH, rel=0.05)
    assert abs(width(quiet) - WIDTH) > 2.0 * abs(width(heard) - WIDTH)


def width(row: Fitted) -> float:
    return row.hypothesis.effects[0].values["width"]
