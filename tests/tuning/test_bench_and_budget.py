"""Runs that failed for another reason than their gains, and a twin that takes long."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import pytest

from gmfbo import Tuner
from gmfbo.errors import NotTheGainsError, SimulationError
from gmfbo.recordings.recording import Recording, Trajectory
from gmfbo.sources.plants.plant_command import CommandPlant
from gmfbo.tuning.methods.gmfbo import CORRECTION, Gmfbo
from gmfbo.tuning.query.progress import Progress
from tests.tuning.analytic_axis import AnalyticAxis, write_study
from tests.tuning.plants.plant_kinds import REFERENCE

GAINS = {"ctl.Kp": 90.0, "ctl.Kd": 4.0}


@dataclass
class Bench(AnalyticAxis):
    """A bench that is not ready at some of its calls, counted from 1."""

    not_ready: frozenset[int] = frozenset()
    asked: list[dict[str, float]] = field(default_factory=list)

    def run(self, gains: Mapping[str, float], reference: Recording) -> Recording:
        self.asked.append(dict(gains))
        if len(self.asked) in self.not_ready:
            raise NotTheGainsError("the drive was not ready")
        return super().run(gains, reference)


@pytest.mark.parametrize("status", [75, 1])
def test_status_75_is_told_apart_from_a_failed_run(tmp_path: Path, status: int) -> None:
    script = f"import sys; open('calls', 'a').write('x'); sys.exit({status})"
    (tmp_path / "script.py").write_text(script, encoding="utf-8")
    plant = CommandPlant((sys.executable, "script.py"), tmp_path, retries=2)
    if status == 75:
        with pytest.raises(NotTheGainsError, match=r"script\.py"):
            plant.run(GAINS, REFERENCE)
    else:
        run = plant.run(GAINS, REFERENCE)
        assert isinstance(run, Trajectory)
        assert run.status == "failed"
    # Retries are for runs that failed; who is at the bench is asked at once.
    assert len((tmp_path / "calls").read_text()) == (1 if status == 75 else 3)


def test_a_bench_that_was_not_ready_is_asked_for_the_same_trial_again(tmp_path: Path) -> None:
    bench = Bench(not_ready=frozenset({2, 3}))
    study = write_study(tmp_path, budget="is1_runs = 4")
    with Tuner(study, is1=bench, is2=AnalyticAxis(inertia=0.16)) as tuner:
        tuner.run()
        real = tuner.history.of("IS1")
    assert bench.asked[1] == bench.asked[2] == bench.asked[3]
    assert [one.status for one in real] == ["ok"] * 4
    assert [one.gains for one in real] == [bench.asked[k] for k in (0, 3, 4, 5)]


def test_the_third_such_run_in_a_row_stops_a_study_which_goes_on_later(tmp_path: Path) -> None:
    bench = Bench(not_ready=frozenset({2, 3, 4}))
    study = write_study(tmp_path, budget="is1_runs = 4")
    with (
        Tuner(study, is1=bench, is2=AnalyticAxis(inertia=0.16)) as tuner,
        pytest.raises(SimulationError, match=r"3 runs in a row .*not ready.*the same gains"),
    ):
        tuner.run()
    with Tuner(study, is1=bench, is2=AnalyticAxis(inertia=0.16)) as tuner:
        tuner.run()
        assert len(tuner.history.of("IS1")) == 4
    assert bench.asked[4] == bench.asked[1]


@dataclass
class SlowTwin(AnalyticAxis):
    """Says that each run takes some seconds."""

    each_s: float = 0.0
    starts_s: float = 0.0

    def run(self, gains: Mapping[str, float], reference: Recording) -> Recording:
        run = super().run(gains, reference)
        assert isinstance(run, Trajectory)
        taken, self.starts_s = self.each_s + self.starts_s, 0.0
        return replace(run, seconds=taken)


SURVEY = 40
QUICK = Gmfbo(correction=replace(CORRECTION, survey=SURVEY, closer=2))


def tuned(folder: Path, each_s: float, starts_s: float = 0.0) -> tuple[Tuner, list[Progress]]:
    """A study of six real runs and at most 1,500 s of the twin, run to its end."""
    study = write_study(folder, budget="is1_runs = 6\nis2_seconds = 1500.0")
    told: list[Progress] = []
    twin = SlowTwin(inertia=0.16, each_s=each_s, starts_s=starts_s)
    with Tuner(study, is1=AnalyticAxis(), is2=twin, method=QUICK) as tuner:
        tuner.run(told.append)
    return tuner, told


def test_a_slow_twin_is_told_before_its_first_runs_and_ends_with_its_time(tmp_path: Path) -> None:
    tuner, told = tuned(tmp_path, each_s=100.0)
    first = told[0]
    assert first.phase == "news"
    # 10 initial ones, the survey, and 1 + 4 + 2 * 4 a real run.
    count = 10 + SURVEY + 13 * 6
    assert f"a twin run takes 100 s: {count} runs or more, {count * 100 / 60:.0f} min" in first.note
    assert "is2_seconds (now 1500)" in first.note
    assert len(tuner.history.of("IS2")) == 15
    assert len(tuner.history.of("IS1")) == 6
    said = [one.note for one in told if "used up" in one.note]
    assert len(said) == 1
    assert "(15 runs, 1500 s" in said[0]


def test_a_quick_twin_is_not_worth_a_line_and_has_its_survey(tmp_path: Path) -> None:
    tuner, told = tuned(tmp_path, each_s=0.01, starts_s=20.0)
    assert not [one for one in told if one.phase == "news"]
    assert len(tuner.history.of("IS2")) > 10 + SURVEY
