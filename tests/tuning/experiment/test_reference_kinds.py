"""References other than one step: what is played, from where it is scored, what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gmfbo import FmuTwin, models_folder
from gmfbo.errors import StudyFileError, TwinFileError
from gmfbo.recordings.recording import Recording
from gmfbo.recordings.reference import step_reference, with_disturbance
from gmfbo.tuning.experiment.experiment import ReferenceExperiment
from gmfbo.tuning.experiment.experiment_series import ExperimentSeries
from gmfbo.tuning.experiment.scoring_terms import ScoringTerms
from gmfbo.tuning.study_file.reference_section import ReferenceSection
from gmfbo.tuning.tuner import Tuner
from tests.tuning.linear_study import linear_study

SERVO = models_folder() / "servo_axis.toml"


def experiment(terms: ScoringTerms | None = None, **keys: Any) -> ReferenceExperiment:
    section = ReferenceSection.model_validate(keys)
    terms = terms or ScoringTerms()
    return ReferenceExperiment.from_section(section, "position", folder=Path(), terms=terms)


def lagging(made: ReferenceExperiment, lag: float) -> Recording:
    time = made.reference.time
    return Recording(time=time, signals={"position": made.target(np.maximum(time - lag, 0.0))})


def test_a_step_may_begin_anywhere() -> None:
    warm, cold = experiment(start=293.15, step=10.0), experiment(step=10.0)
    assert warm.reference.signal("reference")[[0, -1]] == pytest.approx([293.15, 303.15])
    assert ReferenceSection.model_validate({"from": 293.15}).start == 293.15
    run = lagging(cold, 0.02)
    lifted = run.with_signals({"position": run.signal("position") + 293.15})
    assert warm.metrics(lifted) == pytest.approx(cold.metrics(run))


def test_of_several_steps_the_worst_counts() -> None:
    made = experiment(kind="steps", times=[0.1, 0.5], levels=[1.0, -1.0], horizon=0.4)
    assert [(s.initial, s.size) for s in made.steps] == [(0.0, 1.0), (1.0, -2.0)]
    run = lagging(made, 0.05)
    late = run.with_signals(
        {"position": np.where(run.time >= 0.5, made.target(run.time - 0.2), run.signal("position"))}
    )
    assert made.metrics(late)["settling_time"] == pytest.approx(0.2, abs=2e-3)


def test_a_sine_has_a_tracking_error_and_no_step_metrics() -> None:
    made = experiment(kind="sine", amplitude=0.5, frequency=2.0, cycles=3)
    assert made.horizon == pytest.approx(1.5, abs=2e-3)
    found = made.metrics(lagging(made, 0.01))
    assert found.keys() == {"itae", "rms_error"}
    # The difference of two sines that are d apart: 2 A sin(w d / 2), over sqrt(2).
    expected = 2.0 * 0.5 * np.sin(2.0 * np.pi * 2.0 * 0.005) / np.sqrt(2.0)
    assert found["rms_error"] == pytest.approx(expected, rel=0.02)


def test_step_metrics_beside_a_sine_are_those_of_the_step() -> None:
    sine = ReferenceSection(kind="sine", amplitude=1.0, frequency=1.0, cycles=1.0, weight=3.0)
    sections = [ReferenceSection(), sine]
    series = ExperimentSeries.from_sections(sections, "position", folder=Path())
    run = series.join([lagging(part, 0.02) for part in series.parts])
    found = series.metrics(run)
    assert found["settling_time"] == found["settling_time[1]"]
    assert "settling_time[2]" not in found
    mean = 0.25 * found["rms_error[1]"] + 0.75 * found["rms_error[2]"]
    assert found["rms_error"] == pytest.approx(mean)


def test_a_wider_band_settles_sooner_and_a_filter_forgives_noise() -> None:
    time = np.arange(1101, dtype=np.float64) * 1e-3
    noise = np.random.default_rng(0).normal(0.0, 0.02, time.size)
    creep = Recording(time=time, signals={"position": 1.0 - np.exp(-(time - 0.1) / 0.05)})
    noisy = Recording(time=time, signals={"position": np.where(time < 0.1, 0.0, 1.0) + noise})
    narrow, wide = experiment(), experiment(ScoringTerms(band=0.1))
    assert wide.metrics(creep)["settling_time"] == pytest.approx(0.05 * np.log(10.0), abs=1e-3)
    assert narrow.metrics(creep)["settling_time"] == pytest.approx(0.05 * np.log(50.0), abs=1e-3)
    forgiving = experiment(ScoringTerms(filter_s=0.01))
    assert narrow.metrics(noisy)["settling_time"] > 0.9
    assert forgiving.metrics(noisy)["settling_time"] < 0.2


def test_a_disturbance_pushes_the_twin_at_its_port() -> None:
    reference = with_disturbance(step_reference(1.0), "torque", 0.5, 0.6)
    with FmuTwin(SERVO, driven_ports=("torque",), isolated=False) as twin:
        pushed = twin.run({"kp": 40.0, "kd": 0.8}, reference)
        calm = twin.run({"kp": 40.0, "kd": 0.8}, step_reference(1.0))
    apart = pushed.signal("position") - calm.signal("position")
    assert np.all(apart[:600] == 0.0)
    # At rest the controller holds against it: kp times the error is the torque.
    assert apart[-1] == pytest.approx(0.5 / 40.0, rel=0.01)
    assert pushed.units["torque_disturbance"] == "N.m"


@pytest.mark.parametrize("port", ["torqe", "command"])
def test_a_port_that_is_not_there_is_refused(port: str) -> None:
    wired = models_folder() / "drive_split.toml"
    with pytest.raises(TwinFileError, match=r"wire to|\[ports\] has .*did you mean 'torque'"):
        FmuTwin(wired, driven_ports=(port,), isolated=False)


TRACKED = """
[objective]
weights = { rms_error = 0.8, rms_command = 0.2 }
normalise = 4
"""


@pytest.mark.parametrize(
    "reference",
    [
        'kind = "sine"\namplitude = 1e-4\nfrequency = 4.0\ncycles = 2',
        'step = 0.0\nhorizon = 0.4\ndisturbance = { port = "torque", step = 20.0, at = 0.15 }',
    ],
)
def test_a_study_tunes_without_any_step(reference: str, tmp_path: Path) -> None:
    study = linear_study(
        tmp_path, TRACKED, iterations=1, reference=f"[reference]\n{reference}\n[drift]\n"
    )
    with Tuner(study) as tuner:
        best = tuner.run().best
    assert best is not None
    assert best.metrics.keys() >= {"itae", "rms_error", "rms_command", "command_noise", "energy"}
    assert "rise_time" not in best.metrics
    assert study.metric_units["rms_command"] == "V"


def test_step_metrics_without_a_step_are_refused_before_the_first_run(tmp_path: Path) -> None:
    sine = '[reference]\nkind = "sine"\namplitude = 1e-4\nfrequency = 4.0\ncycles = 2\n'
    study = linear_study(tmp_path, reference=sine)
    with pytest.raises(StudyFileError, match=r"weights: '\w+' needs a reference with a step"):
        Tuner(study)
    assert not study.begun


@pytest.mark.parametrize(
    ("section", "words"),
    [
        ('kind = "sine"\nhorizon = 2.0', "'horizon' has no meaning for a reference of kind"),
        ('kind = "steps"\ntimes = [0.1]', 'kind = "steps" needs levels'),
        ('kind = "stairs"', "reference"),
        ("disturbance = { port = 'torque', step = 0.0, at = 0.1 }", "height other than zero"),
    ],
)
def test_a_reference_that_makes_no_sense_is_refused(
    section: str, words: str, tmp_path: Path
) -> None:
    with pytest.raises(StudyFileError, match=words):
        linear_study(tmp_path, reference=f"[reference]\n{section}\n")
