"""The step that every source answers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gmfbo.errors import InputError, RecordingError
from gmfbo.objective.metrics import worst_metrics
from gmfbo.objective.tracking import TRACKING_METRICS
from gmfbo.recordings.recording import Recording, Trajectory
from gmfbo.recordings.reference import step_reference
from gmfbo.tuning.experiment.experiment import ReferenceExperiment, Step
from gmfbo.tuning.study_file.reference_section import ReferenceSection


@pytest.fixture
def experiment() -> ReferenceExperiment:
    section = ReferenceSection(step=2.0, at=0.1, horizon=0.5)
    return ReferenceExperiment.from_section(section, "position", folder=Path(), unit="m")


def test_a_section_becomes_a_step(experiment: ReferenceExperiment) -> None:
    assert experiment.steps == (Step(time=0.1, initial=0.0, size=2.0, horizon=0.5),)
    assert experiment.reference.units == {"reference": "m"}
    assert experiment.reference_size == 2.0


def test_a_recorded_reference_is_searched_for_its_step() -> None:
    made = step_reference(0.5, at=0.2, horizon=1.0)
    lifted = made.with_signals({"reference": made.signal("reference") - 3.0})
    found = ReferenceExperiment.from_recording(lifted, "position", horizon=1.0)
    assert found.begin == pytest.approx(0.2)
    assert (found.steps[0].initial, found.steps[0].size) == (-3.0, 0.5)


def test_a_ramp_has_no_step_metrics_but_a_tracking_error() -> None:
    time = np.linspace(0.0, 1.0, 101)
    ramp = Recording(time=time, signals={"reference": time}, name="ramp.csv")
    found = ReferenceExperiment.from_recording(ramp, "position")
    late = Recording(time=time, signals={"position": time - 0.1})
    assert found.metrics(late).keys() == set(TRACKING_METRICS)
    assert found.metrics(late)["rms_error"] == pytest.approx(0.1)


def test_a_reference_that_never_changes_is_refused() -> None:
    rest = Recording(time=np.arange(5.0), signals={"reference": np.ones(5)}, name="rest.csv")
    with pytest.raises(RecordingError, match=r"rest\.csv: expected a reference that changes"):
        ReferenceExperiment.from_recording(rest, "position")


def test_a_reference_that_ends_before_the_horizon_is_refused() -> None:
    made = step_reference(at=0.2, horizon=0.4)
    with pytest.raises(RecordingError, match=r"expected 1 s after the step at 0\.2 s, it ends at"):
        ReferenceExperiment.from_recording(made, "position", horizon=1.0)


def test_a_run_is_measured_at_its_own_times(experiment: ReferenceExperiment) -> None:
    time = np.linspace(0.0, 0.7, 8)
    ramp = np.clip((time - 0.1) * 10.0, 0.0, 2.0)
    measured = experiment.metrics(Recording(time=time, signals={"position": ramp}))
    assert measured["rise_time"] == pytest.approx(0.16, abs=1e-12)
    assert measured["settling_time"] == pytest.approx(0.196, abs=1e-12)


def test_cells_that_were_not_sampled_are_left_out(experiment: ReferenceExperiment) -> None:
    time = np.linspace(0.0, 0.7, 15)
    ramp = np.clip((time - 0.1) * 10.0, 0.0, 2.0)
    gaps = np.where(np.arange(15) % 2 == 0, ramp, np.nan)
    measured = experiment.metrics(Recording(time=time, signals={"position": gaps}))
    assert measured["rise_time"] == pytest.approx(0.16, abs=1e-12)


def test_a_failed_run_gets_the_worst_case_whatever_it_left(experiment: ReferenceExperiment) -> None:
    failed = Trajectory(time=np.array([0.0]), signals={}, status="crashed")
    unknown = dict.fromkeys(TRACKING_METRICS, np.inf)
    assert experiment.metrics(failed) == {**worst_metrics(0.5), **unknown}


def test_a_good_run_without_the_signal_is_refused(experiment: ReferenceExperiment) -> None:
    run = Recording(time=np.linspace(0, 1, 5), signals={"positon": np.zeros(5)})
    with pytest.raises(RecordingError, match="no signal 'position'; did you mean 'positon'"):
        experiment.metrics(run)
    empty = Recording(time=np.linspace(0, 1, 5), signals={"position": np.full(5, np.nan)})
    with pytest.raises(RecordingError, match="'position' holds no value"):
        experiment.metrics(empty)


def test_a_good_run_that_is_too_short_is_refused(experiment: ReferenceExperiment) -> None:
    run = Recording(time=np.linspace(0, 0.3, 5), signals={"position": np.zeros(5)})
    with pytest.raises(InputError, match=r"samples from 0\.1 to 0\.6 s"):
        experiment.metrics(run)
