"""A law that is not in the library shows as a free function of the states; noise does not."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.numbers import NAMED, TORQUE_TIME
from gmfbo.diagnosis.comparison.opened_comparison import comparison_of
from gmfbo.diagnosis.comparison.unknown_laws import Unknown, unknown_beside
from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin.augmented_twin import AugmentedTwin
from tests.diagnosis.noise.planted_noise import STEP, Planted, opened
from tests.diagnosis.short_recordings import SERVO, moves, multisine, triangle

Array = NDArray[np.float64]
Torque = Callable[[Array, Array, np.random.Generator], Array]


def rippled_drag(position: Array, velocity: Array, rng: np.random.Generator) -> Array:
    """[N m] Drag that changes over the position."""
    return -0.01 * velocity * np.cos(20.0 * position)


def torque_noise(position: Array, velocity: Array, rng: np.random.Generator) -> Array:
    """[N m] With the correlation time of the table."""
    keep, found = np.exp(-STEP / TORQUE_TIME), np.zeros(position.size)
    white = 0.01 * np.sqrt(1.0 - keep**2) * rng.standard_normal(position.size)
    for k in range(1, position.size):
        found[k] = keep * found[k - 1] + white[k]
    return found


def recordings(torque: Torque) -> Planted:
    """A servo axis on which a torque acts that depends on its own motion."""
    rng, twin = np.random.default_rng(1), SERVO.twin()
    time = STEP * np.arange(1400, dtype=np.float64)
    made, columns = [], []
    with AugmentedTwin(twin, substeps=10, isolated=False) as simulator:
        for k, reference in enumerate((multisine, moves, triangle)):
            asked = Recording(
                time=time,
                signals={SERVO.driven: reference(time)},
                name=f"rec{k}.csv",
                parameters=SERVO.gains,
                written_by="test",
            )
            plan, column = simulator.plan(asked, SERVO.truth), 2e-5 * rng.standard_normal(1400)
            acting, seed = np.zeros(plan.grid.size), int(rng.integers(1000))
            for _ in range(4):  # until the motion is that under its own torque
                pushed = {"sensor": column, "torque": acting}
                run = simulator.run(plan, SERVO.truth, {}, excitation=pushed)
                states = run.states
                acting = torque(states["position"], states["velocity"], np.random.default_rng(seed))
            signals = {**run.held, "position": run.held["position"] + column}
            made.append(
                Recording(
                    time=time,
                    signals={SERVO.driven: reference(time), **signals},
                    name=asked.name,
                    parameters=SERVO.gains,
                    written_by="test",
                )
            )
            columns.append(column)
    return Planted(twin, made, columns)


def left(torque: Torque) -> Unknown:
    with opened(recordings(torque)) as case:
        search = (stated := comparison_of(case, [])).search
        ledger = search.opened(stated.first)
        found = unknown_beside(search.problem, ledger, ledger.rows[frozenset()], search.tolerance)
    assert found is not None
    return found


def test_a_law_over_the_position_is_seen_and_its_state_told() -> None:
    found = left(rippled_drag)
    assert found.probability >= NAMED
    assert found.log_odds > 30.0
    assert (found.port, found.against) == ("torque", "position")


def test_noise_of_the_shaft_is_no_law() -> None:
    found = left(torque_noise)
    assert found.probability < 0.5
    assert found.log_odds == pytest.approx(0.0, abs=3.0)
