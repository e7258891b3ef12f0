"""How long the first reference is held before a run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from gmfbo import FmuTwin, Recording, step_reference
from gmfbo.sources.twin.settling import probe_lengths, settled_after
from tests.sources.conftest import AXIS, LOOP

if TYPE_CHECKING:
    from tests.sources.conftest import WriteTwin

STEP = 1e-3
TIME = np.arange(1001, dtype=np.float64) * STEP


def test_probes_are_whole_windows_at_any_step() -> None:
    assert probe_lengths(1e-3) == [50, 1000, 5000]
    assert probe_lengths(1e-4) == [500, 10000, 50000]
    assert probe_lengths(0.2) == [1, 20, 100]


def test_a_decay_settles_when_its_closed_form_says_so() -> None:
    """exp(-t/T) moves by exp(-t/T) (1 - exp(-w/T)) in a window of w seconds."""
    time_constant = 0.02
    decay = np.exp(-TIME / time_constant)[:, np.newaxis]
    settled = settled_after(decay, STEP)
    assert settled is not None
    first_quiet = time_constant * np.log((1.0 - np.exp(-0.049 / time_constant)) / 1e-6)
    assert first_quiet <= settled * STEP - 0.05 + 2 * STEP
    assert settled * STEP - 0.05 < first_quiet + 0.05


def test_what_is_at_rest_from_its_start_needs_no_step() -> None:
    assert settled_after(np.full((51, 2), 0.25), STEP) == 0
    rounding = 1e-13 * np.sin(1e3 * TIME)[:, np.newaxis]
    assert settled_after(rounding, STEP) == 0


def test_a_limit_cycle_a_ramp_and_a_slow_decay_have_not_settled_after_a_second() -> None:
    for motion in (np.sin(40.0 * TIME), TIME, TIME**2, np.exp(-TIME / 0.8)):
        assert settled_after(motion[:, np.newaxis], STEP) is None


def test_one_restless_output_keeps_the_others_waiting() -> None:
    outputs = np.column_stack([np.zeros(1001), np.sin(40.0 * TIME)])
    assert settled_after(outputs, STEP) is None


def test_a_recording_that_starts_away_from_zero_starts_at_rest_there(axis: Path) -> None:
    reference = Recording(time=TIME[:201], signals={"reference": np.full(201, 0.2)})
    with FmuTwin(axis) as twin:
        run = twin.run({}, reference)
        np.testing.assert_allclose(run.signal("position"), 0.2, rtol=1e-5)
        np.testing.assert_allclose(run.signal("drive_voltage"), 0.0, atol=1e-2)
        assert run.time[0] == 0.0
        assert len(run) == 201


def test_the_step_response_does_not_depend_on_where_it_starts(axis: Path) -> None:
    """The axis is linear below its voltage limit: shifting the reference shifts the response."""
    step = step_reference(1e-4, at=0.05, horizon=0.2, unit="m")
    shifted = step.with_signals({"reference": step.signal("reference") + 0.3})
    with FmuTwin(axis) as twin:
        low, high = twin.run({}, step), twin.run({}, shifted)
    np.testing.assert_allclose(
        high.signal("position") - 0.3, low.signal("position"), atol=2e-6, rtol=0.0
    )


def test_at_rest_the_fmu_starts_at_the_recordings_first_time(
    axis: Path, write_twin: WriteTwin
) -> None:
    """No step is simulated before: the run is that of a plain master from t0."""
    step = step_reference(0.01, at=0.05, horizon=0.2, unit="m")
    with FmuTwin(axis) as settled:
        one = settled.run({}, step)
    with FmuTwin(write_twin(AXIS + "[initial]\ninitial_position = 0.0\n")) as direct:
        other = direct.run({}, step)
    assert one.signal("position").tobytes() == other.signal("position").tobytes()


def test_a_plant_that_runs_away_starts_where_its_fmu_starts(write_twin: WriteTwin) -> None:
    """A force of 6 N against 60 N s/m: v = 0.1 (1 - exp(-30 t)) from rest, position a ramp."""
    text = LOOP.partition("[wires]")[0] + (
        '[inputs]\nforce = "plant.port.force"\n[outputs]\nposition = "plant.true_position"\n'
        'velocity = "plant.velocity"\n[parameters]\n"plant.kp" = 0.0\n"plant.kv" = 0.0\n'
        '"plant.mass" = 2.0\n"plant.viscous_friction" = 60.0\n'
    )
    push = Recording(time=TIME[:301], signals={"force": np.full(301, 6.0)})
    with FmuTwin(write_twin(text)) as twin:
        run = twin.run({}, push)
    speed = 0.1 * (1.0 - np.exp(-30.0 * TIME[:301]))
    np.testing.assert_allclose(run.signal("velocity"), speed, atol=1e-7)


@pytest.mark.parametrize("gains", [(160.0, 243.0), (40.0, 60.0)])
def test_soft_gains_are_waited_for(gains: tuple[float, float], axis: Path) -> None:
    reference = Recording(time=TIME[:51], signals={"reference": np.full(51, 0.01)})
    with FmuTwin(axis) as twin:
        run = twin.run(gains, reference)
    np.testing.assert_allclose(run.signal("position"), 0.01, rtol=1e-4)
