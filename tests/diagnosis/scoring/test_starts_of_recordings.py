"""Where a recording starts: as its twin, elsewhere, or as another recording that it repeats."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.runs.scored_record import Record, scored_record
from gmfbo.diagnosis.runs.simulated import Simulated
from gmfbo.diagnosis.scoring.covariances import covariances
from gmfbo.diagnosis.scoring.signal_parts import describe_rig
from gmfbo.diagnosis.scoring.windows import windows_of
from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin.augmented_twin import AugmentedTwin
from tests.diagnosis.short_recordings import SERVO

TIME = np.arange(500, dtype=np.float64) * 1e-3
LOOP_TIME = 0.02
NOISE = 3e-5 * np.random.default_rng(4).standard_normal((2, TIME.size))


def recorded(position: NDArray[np.float64], name: str = "a.csv") -> Record:
    """A recording whose reference is the same for all."""
    signals = {"reference": np.zeros(TIME.size), "position": position}
    recording = Recording(time=TIME, signals=signals, name=name, parameters=SERVO.gains)
    with AugmentedTwin(SERVO.twin(), isolated=False) as simulator:
        return scored_record(recording, simulator.plan(recording, {}), ("position",), 0.0)


def first_row(position: NDArray[np.float64], simulated: NDArray[np.float64]) -> int:
    """First scored row of a recording beside its twin."""
    twin = cast(Simulated, SimpleNamespace(signals=[simulated]))
    return int(windows_of([recorded(position)], LOOP_TIME, [twin], {"position"})[0].rows[0].start)


def let_go(acceleration: float) -> NDArray[np.float64]:
    """Position [rad] of an axis that is let go at 0.1 rad, and swings to and fro."""
    swinging: NDArray[np.float64] = 0.1 * np.cos(np.sqrt(acceleration / 0.1) * TIME)
    return swinging


def test_an_axis_that_is_let_go_starts_as_its_twin_though_it_accelerates_otherwise() -> None:
    assert first_row(let_go(40.0) + NOISE[0], let_go(12.0)) == 0


@pytest.mark.parametrize("speed", [1.0, -1.0])
def test_control_an_axis_that_moves_at_the_start_does_not(speed: float) -> None:
    moving = let_go(40.0) + speed * TIME + NOISE[0]
    assert first_row(moving, let_go(40.0)) >= 10.0 * LOOP_TIME / 1e-3 - 1.0


def excess(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    """Largest share by which a second recording raises the covariance of the first."""
    records = [recorded(one), recorded(other, "b.csv")]
    rig = describe_rig(SERVO.twin().binding, [signal.name for signal in records[0].signals])
    windows = windows_of(records, LOOP_TIME)
    own: list[list[float]] = [[9e-10], [9e-10]]
    both = covariances(windows, records, rig, own, [[], []])
    alone = covariances(windows[:1], records[:1], rig, own[:1], [[]])
    return float(np.max(np.abs(both[0] / alone[0]))) - 1.0


def test_what_differs_between_repeats_counts_as_noise() -> None:
    wandering = 1e-3 * (1.0 - np.cos(2.0 * np.pi * TIME / 0.5))
    assert excess(let_go(40.0) + NOISE[0], let_go(40.0) + wandering + NOISE[1]) > 1.0


def test_control_recordings_let_go_from_different_places_are_no_repeats() -> None:
    assert excess(let_go(40.0) + NOISE[0], 0.5 * let_go(40.0) + NOISE[1]) == 0.0
