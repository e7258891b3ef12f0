"""The torque that a recording asks for, against one that was put in."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.latent import latent_torque
from tests.diagnosis.port_cases import PortCase, open_servo, port_case


@pytest.fixture(scope="module")
def servo() -> Iterator[PortCase]:
    case = open_servo({})
    yield port_case(case)
    case.simulations.close()


def torque_at(time: NDArray[np.float64]) -> NDArray[np.float64]:
    """A sine that is switched on, and a step."""
    on: NDArray[np.float64] = 0.2 * np.sin(2.0 * np.pi * 3.0 * time) * (time > 0.5)
    return on + 0.1 * (time > 1.2)


def without_torque(servo: PortCase) -> Fitted:
    """Fitted twin whose simulation lacks that torque: its recordings then ask for it."""
    case, runs = servo.case, []
    point = case.base.hypothesis.point(case.base.x)
    for k, before in enumerate(case.base.simulated):
        torque = torque_at(case.simulations.records[k].plan.grid)
        after = case.simulations.run_one(point, k, excitation={"torque": torque})
        signals = [2.0 * b - a for a, b in zip(after.signals, before.signals, strict=True)]
        runs.append(replace(before, quiet=tuple(signals)))
    return replace(case.base, simulated=runs)


def test_a_torque_put_into_the_fmu_comes_back_within_its_error(servo: PortCase) -> None:
    for latent in latent_torque(servo.case, without_torque(servo), servo.response):
        known = np.isfinite(latent.standard_error)
        error = (latent.torque - torque_at(latent.time))[known]
        assert known.mean() > 0.9
        assert np.sqrt(np.mean(error**2)) < 2.5 * latent.standard_error[known][0]
        assert np.sqrt(np.mean(error**2)) < 0.3 * np.sqrt(np.mean(torque_at(latent.time) ** 2))


def test_a_right_twin_asks_for_next_to_nothing(servo: PortCase) -> None:
    for latent in latent_torque(servo.case, servo.case.base, servo.response):
        known = np.isfinite(latent.standard_error)
        rms = np.sqrt(np.mean(latent.torque[known] ** 2))
        # Where nothing stands out of the noise both are zero.
        assert rms <= 2.5 * latent.standard_error[known][0]


def test_what_is_not_scored_or_not_yet_answered_has_no_bound(servo: PortCase) -> None:
    for latent in latent_torque(servo.case, servo.case.base, servo.response):
        assert np.isinf(latent.standard_error[-1])
        assert latent.torque.shape == latent.standard_error.shape == latent.time.shape
