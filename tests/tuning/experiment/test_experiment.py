"""The step that every source answers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gmfbo.errors import InputError, RecordingError
from gmfbo.objective.metrics import worst_metrics
from gmfbo.recordings.recording import Recording, Trajectory
from gmfbo.recordings.reference import step_reference
from gmfbo.tuning.experiment.experiment import StepExperiment
from gmfbo.tuning.study_file.study_sections import ReferenceSection


@pytest.fixture
def experiment() -> StepExperiment:
    section = ReferenceSection(step=2.0, at=0.1, horizon=0.5)
    return StepExperiment.from_section(section, "position", folder=Path(), unit="m")


def test_a_section_becomes_a_step(experiment: StepExperiment) -> None:
    assert (experiment.step_time, experiment.initial, experiment.step_size) == (0.1, 0.0, 2.0)
    assert experiment.reference.units == {"reference": "m"}
    assert experiment.reference_size == 2.0


def test_a_recorded_reference_is_searched_for_its_step() -> None:
    made = step_reference(0.5, at=0.2, horizon=1.0)
    lifted = made.with_signals({"reference": made.signal("reference") - 3.0})
    found = StepExperiment.from_recording(lifted, "reference", "position", horizon=1.0)
    assert found.step_time == pytest.approx(0.2)
    assert (found.initial, found.step_size) == (-3.0, 0.5)


def test_a_reference_that_is_no_step_is_refused() -> None:
    time = np.linspace(0.0, 1.0, 11)
    ramp = Recording(time=time, signals={"reference": time}, name="ramp.csv")
    with pytest.raises(RecordingError, match=r"ramp\.csv: expected 'reference' to step once, it"):
        StepExperiment.from_recording(ramp, "reference", "position", horizon=0.5)


def test_a_reference_that_ends_before_the_horizon_is_refused() -> None:
    made = step_reference(at=0.2, horizon=0.4)
    with pytest.raises(RecordingError, match=r"expected 1 s after the step at 0\.2 s, it ends at"):
        StepExperiment.from_recording(made, "reference", "position", horizon=1.0)


def test_a_run_is_measured_at_its_own_times(experiment: StepExperiment) -> None:
    time = np.linspace(0.0, 0.7, 8)
    ramp = np.clip((time - 0.1) * 10.0, 0.0, 2.0)
    measured = experiment.metrics(Recording(time=time, signals={"position": ramp}))
    assert measured["rise_time"] == pytest.approx(0.16, abs=1e-12)
    assert measured["settling_time"] == pytest.approx(0.196, abs=1e-12)


def test_cells_that_were_not_sampled_are_left_out(experiment: StepExperiment) -> None:
    time = np.linspace(0.0, 0.7, 15)
    ramp = np.clip((time - 0.1) * 10.0, 0.0, 2.0)
    gaps = np.where(np.arange(15) % 2 == 0, ramp, np.nan)
    measured = experiment.metrics(Recording(time=time, signals={"position": gaps}))
    assert measured["rise_time"] == pytest.approx(0.16, abs=1e-12)


def test_a_failed_run_gets_the_worst_case_whatever_it_left(experiment: StepExperiment) -> None:
    failed = Trajectory(time=np.array([0.0]), signals={}, status="crashed")
    assert experiment.metrics(failed) == worst_metrics(0.5)


def test_a_good_run_without_the_signal_is_refused(experiment: StepExperiment) -> None:
    run = Recording(time=np.linspace(0, 1, 5), signals={"positon": np.zeros(5)})
    with pytest.raises(RecordingError, match="no signal 'position'; did you mean 'positon'"):
        experiment.metrics(run)
    empty = Recording(time=np.linspace(0, 1, 5), signals={"position": np.full(5, np.nan)})
    with pytest.raises(RecordingError, match="'position' holds no value"):
        experiment.metrics(empty)


def test_a_good_run_that_is_too_short_is_refused(experiment: StepExperiment) -> None:
    run = Recording(time=np.linspace(0, 0.3, 5), signals={"position": np.zeros(5)})
    with pytest.raises(InputError, match=r"samples from 0\.1 to 0\.6 s"):
        experiment.metrics(run)
