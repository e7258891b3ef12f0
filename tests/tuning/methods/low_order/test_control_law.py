from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.tuning.methods.low_order.closed_loop import PlantModel, simulate
from gmfbo.tuning.methods.low_order.control_law import ControlLaw
from gmfbo.tuning.methods.low_order.identification import identify
from gmfbo.tuning.methods.low_order.runs import SampledRuns

STEP, ROWS = 1e-3, 300
KP, KD = 60.0, 2.0
INERTIA, VISCOUS = 0.012, 0.05


def pd_loop(kp: float, kd: float, most: float = np.inf) -> tuple[NDArray[np.float64], ...]:
    """u_k = sat(kp (r - y) - kd dy / T) on J y'' = u - b y', solved exactly a sample at a time."""
    decay = np.exp(-VISCOUS / INERTIA * STEP)
    reach = (1.0 - decay) * INERTIA / VISCOUS
    reference = np.where(np.arange(ROWS) >= 20, 0.5, 0.0)
    y, u, velocity, before = np.zeros(ROWS), np.zeros(ROWS), 0.0, 0.0
    for k in range(1, ROWS):
        rate = (y[k - 1] - before) / STEP
        before = y[k - 1]
        u[k] = np.clip(kp * (reference[k - 1] - y[k - 1]) - kd * rate, -most, most)
        after = decay * velocity + reach * u[k] / INERTIA
        y[k] = y[k - 1] + 0.5 * STEP * (velocity + after)
        velocity = after
    return reference, y, u


def runs(count: int, most: float = np.inf, seed: int = 0) -> SampledRuns:
    rng = np.random.default_rng(seed)
    gains = rng.uniform(0.2, 1.0, size=(count, 2))
    each = [pd_loop(KP * kp, KD * kd, most) for kp, kd in gains]
    reference, y, u = (np.stack(columns) for columns in zip(*each, strict=True))
    return SampledRuns(STEP * np.arange(ROWS, dtype=np.float64), gains, reference, y, u)


@pytest.mark.parametrize("most", [np.inf, 12.0])
def test_a_pd_law_is_read_to_its_coefficients(most: float) -> None:
    law = ControlLaw.read(runs(10, most))
    assert law.is_read
    assert law.high == most
    (found,) = law.coefficients(np.array([[1.0, 0.5]]))
    expected = [KP, 0.0, 0.0, -KP, -0.5 * KD / STEP, 0.0, 0.0, 0.0]
    assert found == pytest.approx(expected, rel=1e-6, abs=1e-5)


def test_control_commands_that_follow_no_law_are_not_read() -> None:
    told = runs(10)
    noise = np.random.default_rng(1).standard_normal(told.command.shape)
    broken = SampledRuns(told.time, told.gains, told.reference, told.measured, noise)
    assert not ControlLaw.read(broken).is_read


def test_inertia_and_friction_follow_from_two_runs() -> None:
    law = ControlLaw.read(runs(10))
    found = identify(law, runs(2, seed=5))
    assert found.plant.gain[0] == pytest.approx(1.0 / INERTIA, rel=1e-3)
    assert found.plant.damping[0] == pytest.approx(VISCOUS / INERTIA, rel=1e-2)
    assert found.plant.delay[0] < 1e-5
    assert "coulomb" not in found.names


def test_friction_holds_a_loop_short_of_its_reference() -> None:
    law = ControlLaw.read(runs(10))
    gains = np.array([[0.3, 0.5]])
    level, zero = 1.0, np.zeros(1)
    plant = PlantModel(np.array([1 / INERTIA]), zero, zero, np.array([level / INERTIA]), zero, zero)
    reference = np.where(np.arange(4000) >= 20, 0.5, 0.0)[None, :]
    y, _ = simulate(law, plant, gains, reference, np.zeros((2, 1)), STEP)
    error = 0.5 - y[0, -1]
    assert 0.0 < abs(error) <= level / (0.3 * KP) * (1.0 + 1e-9)  # at its end, up to rounding
    assert y[0, -1] == y[0, -100]  # it rests
