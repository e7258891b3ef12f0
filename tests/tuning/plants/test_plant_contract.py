"""What every kind of plant must do: right recordings, priced failures, nothing lost, resume."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from gmfbo.recordings.recording import Trajectory
from gmfbo.recordings.store.trial import Trial
from gmfbo.tuning.study.study import Study
from tests.tuning.analytic_axis import AnalyticAxis
from tests.tuning.plants.bench import TRIPS_ABOVE
from tests.tuning.plants.plant_kinds import KINDS, REFERENCE, PlantKind

ROOT = Path(__file__).resolve().parents[3]


def real_runs(study: Study) -> list[Trial]:
    return [trial for trial in study.trials if trial.source == "IS1"]


@pytest.fixture(scope="module", params=sorted(KINDS))
def kind(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="module")
def finished(kind: str, tmp_path_factory: pytest.TempPathFactory) -> Study:
    study = KINDS[kind].study(tmp_path_factory.mktemp(kind) / "whole")
    KINDS[kind].finish(study, lambda trial: None)
    return study


def test_a_run_holds_what_the_axis_does_at_its_gains(finished: Study) -> None:
    succeeded = [trial for trial in real_runs(finished) if trial.status == "ok"]
    assert len(succeeded) >= 3
    for trial in succeeded:
        exact = AnalyticAxis().run(trial.gains, REFERENCE)
        assert dict(trial.recording.parameters) == trial.gains
        np.testing.assert_allclose(trial.recording.time, exact.time, rtol=0, atol=1e-12)
        for signal_name in ("reference", "position"):
            np.testing.assert_allclose(
                trial.recording.signal(signal_name), exact.signal(signal_name), atol=1e-9
            )


def test_a_failed_run_is_priced_and_the_study_goes_on(finished: Study) -> None:
    runs = real_runs(finished)
    assert len(runs) == 8
    failed = [trial for trial in runs if trial.status != "ok"]
    assert [t.number for t in failed] == [t.number for t in runs if t.gains["ctl.Kp"] > TRIPS_ABOVE]
    assert failed
    assert failed[0].number < runs[-1].number
    assert finished.objective is not None
    for trial in failed:
        assert trial.status == "failed"
        assert trial.objective == pytest.approx(finished.objective.failed)
        assert np.isfinite(trial.objective)
        assert isinstance(trial.recording, Trajectory)
        assert "the drive tripped" in trial.recording.message


def test_gains_lie_in_the_box_and_no_two_runs_are_alike(finished: Study) -> None:
    gains = [tuple(trial.gains.values()) for trial in real_runs(finished)]
    assert len(set(gains)) == len(gains)
    assert all(30.0 <= kp <= 200.0 and 2.0 <= kd <= 10.0 for kp, kd in gains)


@pytest.mark.parametrize(
    ("plant", "how"), [("command", signal.SIGINT), ("ask_tell", signal.SIGKILL)]
)
def test_a_study_that_was_stopped_keeps_all_and_goes_on_the_same(
    tmp_path: Path, plant: str, how: signal.Signals
) -> None:
    whole = KINDS[plant].study(tmp_path / "whole")
    KINDS[plant].finish(whole, lambda trial: None)
    goes_on_the_same(tmp_path, plant, whole, how)


@pytest.mark.slow
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGKILL])
def test_a_study_of_every_kind_that_was_stopped_in_either_way_goes_on_the_same(
    tmp_path: Path, kind: str, finished: Study, how: signal.Signals
) -> None:
    goes_on_the_same(tmp_path, kind, finished, how)


def goes_on_the_same(tmp_path: Path, kind: str, finished: Study, how: signal.Signals) -> None:
    plant, folder = KINDS[kind], tmp_path / "stopped"
    stopped = plant.study(folder)
    seen = stop_after(kind, folder, how)
    kept = [trial.number for trial in stopped.trials]
    assert kept == list(range(1, len(kept) + 1))
    assert seen in kept
    assert len(kept) < len(finished.trials)
    plant.finish(stopped, lambda trial: None)
    assert outcome(stopped) == outcome(finished)


def stop_after(kind: str, folder: Path, how: signal.Signals) -> int:
    """Stop a study while it makes its fifth real run; the last trial that it reported."""
    with subprocess.Popen(
        [sys.executable, "-m", "tests.tuning.plants.plant_kinds", kind, str(folder)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    ) as process:
        assert process.stdout is not None
        seen = next(int(line) for line in process.stdout if int(line) >= 14)
        process.send_signal(how)
        assert process.wait(timeout=30.0) != 0
    return seen


def outcome(study: Study) -> list[tuple[object, ...]]:
    return [(t.number, t.source, t.gains, t.objective, t.status) for t in study.trials]


def test_kinds_name_themselves_in_the_study_file(kind: str, tmp_path: Path) -> None:
    plant: PlantKind = KINDS[kind]
    section = plant.study(tmp_path / "named").file.is1
    given = [section.command, section.recorded, section.ask_tell or None]
    assert sum(value is not None for value in given) == 1
