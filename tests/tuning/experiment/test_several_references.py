"""Several references in one objective: each query plays all, a trial holds all."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gmfbo import FmuTwin
from gmfbo.errors import RecordingError
from gmfbo.recordings.recording import Trajectory
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.tuning.tuner import Tuner
from tests.tuning.linear_study import linear_study

TWO = """
[[reference]]
step = 2e-4
at = 0.05
horizon = 0.4
weight = 3.0
[[reference]]
step = -1e-3
at = 0.1
horizon = 0.3
"""


def test_a_query_plays_all_references_and_its_trial_holds_them(tmp_path: Path) -> None:
    study = linear_study(tmp_path, reference=TWO, iterations=2)
    with Tuner(study) as tuner:
        tuner.run()
        experiment = tuner.experiment
    trial = study.trials[-1]
    assert trial.source == "IS1"
    with FmuTwin(models_folder() / "linear_axis.toml", isolated=False) as twin:
        for number, reference in enumerate(experiment.references):
            alone = twin.run(trial.gains, reference)
            held = experiment.part_of(trial.recording, number)
            np.testing.assert_allclose(held.time, alone.time, atol=1e-12)
            np.testing.assert_array_equal(held.signal("position"), alone.signal("position"))
            each = experiment.parts[number].metrics(alone)
            for name, value in each.items():
                assert trial.metrics[f"{name}[{number + 1}]"] == pytest.approx(value)
    for name in ("rise_time", "overshoot"):
        mean = 0.75 * trial.metrics[f"{name}[1]"] + 0.25 * trial.metrics[f"{name}[2]"]
        assert trial.metrics[name] == pytest.approx(mean)


@pytest.mark.parametrize("asked", ["rise_time", "rise_time[2]", "itae"])
def test_what_is_asked_for_is_as_among_all_metrics(tmp_path: Path, asked: str) -> None:
    study = linear_study(tmp_path, reference=TWO, iterations=0)
    with Tuner(study) as tuner:
        experiment = tuner.experiment
    times = experiment.scored_times(400)
    target = np.where(times < times[200], 2e-4, -1e-3)
    responses = target * (1.0 - np.exp(-np.outer([10.0, 30.0], times)))
    whole, part = (experiment.metrics_of(times, responses, n) for n in (None, {asked}))
    assert len(part) < len(whole)
    np.testing.assert_array_equal(part[asked], whole[asked])


def test_the_weight_decides_which_reference_counts(tmp_path: Path) -> None:
    costs = []
    for weight in (1e-6, 1e6):
        study = linear_study(
            tmp_path / f"{weight}",
            "[objective]\nweights = { rise_time = 1.0 }\n",
            reference=TWO.replace("weight = 3.0", f"weight = {weight}"),
            method="random",
            iterations=0,
        )
        with Tuner(study) as tuner:
            tuner.run()
        real = [trial for trial in study.trials if trial.source == "IS1"]
        costs.append([trial.metrics["rise_time"] for trial in real])
        single = [trial.metrics[f"rise_time[{2 if weight < 1 else 1}]"] for trial in real]
        assert costs[-1] == pytest.approx(single, rel=1e-3)
    assert costs[0] != pytest.approx(costs[1], rel=1e-2)


def test_a_limit_holds_for_each_reference_not_for_their_mean(tmp_path: Path) -> None:
    study = linear_study(tmp_path, "[constraints]\novershoot = 20.0\n", reference=TWO, iterations=4)
    with Tuner(study) as tuner:
        tuner.run()
        seen = {one.number: one for one in tuner.history.observations() if one.source == "IS1"}
    for trial in study.trials:
        if trial.source == "IS1":
            worst = max(trial.metrics["overshoot[1]"], trial.metrics["overshoot[2]"])
            assert seen[trial.number].limited["overshoot"] == worst
            assert seen[trial.number].feasible == (worst <= 20.0)


def test_corrected_runs_cover_all_references(tmp_path: Path) -> None:
    study = linear_study(tmp_path, reference=TWO, method="gmfbo_paper", iterations=1)
    with Tuner(study) as tuner:
        tuner.run()
        times = tuner.experiment.scored_times(40)
    assert len(times) == 40
    assert np.all(np.diff(times) > 0)
    drawn = [trial for trial in study.trials if trial.source == "IS3" and trial.accepted]
    assert drawn
    assert all(trial.recording.time[-1] > times[-1] - 1e-9 for trial in drawn)


def test_an_unsafe_reference_ends_the_query_before_the_next(tmp_path: Path) -> None:
    study = linear_study(
        tmp_path,
        "[safety]\ndrive_voltage = [-0.1, 0.1]\n",
        reference=TWO,
        method="random",
        iterations=1,
    )
    with Tuner(study) as tuner:
        tuner.run()
        second = tuner.experiment.offsets[1]
    for trial in study.trials:
        if trial.source == "IS1":
            run = trial.recording
            assert isinstance(run, Trajectory)
            assert run.status == "unsafe"
            assert run.message.startswith("reference 1: left the safety envelope")
            assert run.time[-1] < second


def test_a_person_tells_one_recording_a_reference(tmp_path: Path) -> None:
    study = linear_study(tmp_path, reference=TWO, iterations=0)
    with (
        FmuTwin(models_folder() / "linear_axis.toml", isolated=False) as axis,
        Tuner(study) as tuner,
    ):
        request = tuner.ask()
        assert request is not None
        runs = [axis.run(request.gains, one) for one in tuner.experiment.references]
        for wrong in ([runs[0]], [*runs, runs[0]]):
            with pytest.raises(RecordingError, match="expected 2 recordings, one a"):
                tuner.tell(request, wrong)
        told = tuner.tell(request, runs)
    assert told.status == "ok"
    assert told.metrics["overshoot[2]"] >= 0.0
