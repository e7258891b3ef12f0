"""Studies on the drive whose twin has a noisy flux map: the twin is corrected as they run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gmfbo import Study, Tuner
from gmfbo.recordings.store.study_folder import StudyStore
from gmfbo.recordings.store.trial import Trial
from gmfbo.retuning.corrected_methods import (
    GMFBO_CALIBRATED,
    OnCorrectedTwin,
)
from gmfbo.retuning.real_runs import plain_recordings
from gmfbo.retuning.refiner import PhysicsRefiner
from gmfbo.retuning.twin_guard import misleads
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.twin.twin import FmuTwin
from gmfbo.sources.twin.twin_at import TwinAt
from gmfbo.sources.twin.uncertain import uncertain_of
from gmfbo.tuning.drift.drift import Drift
from gmfbo.tuning.history.history import History
from gmfbo.tuning.query.method import CorrectionOptions
from gmfbo.tuning.twin.learned import learned_lines
from gmfbo.tuning.twin.twin_version import TwinVersion
from tests.retuning.smoothed_once import SMOOTHED_ONCE

OPTIONS = CorrectionOptions(survey=12)
STUDY = """
name = "drive"
seed = 3
method = "gmfbo_calibrated"
[is1]
twin = "{models}/drive_twin.toml"
{plant}
[is2]
twin = "{models}/drive_twin.toml"
parameters = {{ "map.noise" = {noise}, "map.seed" = "seed" }}
[reference]
step = 1.0
{shape}
[budget]
initial_is1 = 2
initial_is2 = 10
is1_runs = {runs}
is3_per_run = 1
"""
SHORT = "at = 0.05\nhorizon = 0.3"
"""What takes the drive's time is how long it is simulated."""


def study_in(
    folder: Path, *, runs: int = 4, noise: float = 0.5, plant: str = "", shape: str = SHORT
) -> Study:
    folder.mkdir(exist_ok=True)
    models = models_folder().as_posix()
    text = STUDY.format(models=models, runs=runs, noise=noise, plant=plant, shape=shape)
    (folder / "drive.toml").write_text(text, encoding="utf-8")
    return Study.read(folder / "drive.toml")


def events(study: Study, name: str) -> list[dict[str, Any]]:
    with StudyStore.open(study.location) as store:
        return [event for event in store.events() if event["event"] == name]


def position_error(one: Trial, other: Trial) -> float:
    """RMS difference [rad]."""
    difference = one.recording.signal("position") - other.recording.signal("position")
    return float(np.sqrt(np.mean(difference**2)))


def beside(trials: Sequence[Trial], real: Trial) -> list[Trial]:
    """Twin runs at the gains of a real run, in the order in which they were made."""
    return [t for t in trials if t.source == "IS2" and t.parent == real.number]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Study:
    study = study_in(tmp_path_factory.mktemp("whole"))
    with Tuner(study, method=replace(GMFBO_CALIBRATED, correction=OPTIONS)) as tuner:
        tuner.run()
    return study


def test_the_corrected_twin_predicts_runs_it_has_not_seen(whole: Study) -> None:
    trials = whole.trials
    third = [t for t in trials if t.source == "IS1"][2]
    predicted = beside(trials, third)[0]
    with FmuTwin(
        models_folder() / "drive_twin.toml", parameters={"map.noise": 0.5, "map.seed": 3.0}
    ) as given:
        reference = third.recording
        run = given.run(third.gains, replace(reference, parameters={}))
    as_given = replace(predicted, recording=run)
    assert position_error(predicted, third) < 0.2 * position_error(as_given, third)


def test_each_version_is_logged_with_its_reason_and_what_it_is(whole: Study) -> None:
    versions = events(whole, "twin_version")
    assert [event["version"] for event in versions] == list(range(1, len(versions) + 1))
    first = versions[0]
    assert first["reason"] == "estimated from 2 real runs"
    assert len(first["parameters"]) == 52
    assert 0.07 <= first["parameters"]["load.inertia"] <= 0.28
    assert set(first["errors"]) == {"position", "torque_command", "velocity"}


def test_what_the_twin_learned_is_told_with_intervals(whole: Study) -> None:
    last = events(whole, "twin_version")[-1]
    learned = {one["name"]: one for one in last["learned"]}
    assert set(learned) == set(uncertain_of_drive())
    for name, one in learned.items():
        # The plant is the twin as shipped, apart from its table.
        assert one["before"] == pytest.approx(uncertain_of_drive()[name])
        assert one["low"] <= one["after"] <= one["high"]
        assert one["after"] == last["parameters"][name]
    inertia = learned["load.inertia"]
    assert inertia["low"] <= inertia["before"] <= inertia["high"]
    assert inertia["high"] - inertia["low"] < 0.5 * (0.28 - 0.07)  # narrower than was believed
    assert abs(inertia["after"] - inertia["before"]) > 1e-3  # so that the interval has a say
    lines = learned_lines(last)
    assert any(line.startswith("load.inertia: 0.14 -> ") for line in lines)
    assert any(line.startswith("table flux_q: its nodes moved by ") for line in lines)


def uncertain_of_drive() -> dict[str, float]:
    with FmuTwin(models_folder() / "drive_twin.toml") as twin:
        return {one.name: one.nominal for one in uncertain_of(twin)}


def test_the_twin_runs_again_wherever_it_was_run(whole: Study) -> None:
    first = events(whole, "twin_version")[0]["twin"]
    runs = [t for t in whole.trials if t.source == "IS2" and t.parent is None]
    as_given = [t for t in runs if t.twin == runs[0].twin]
    again = [t for t in runs if t.twin == first]
    assert [dict(t.gains) for t in again] == [dict(t.gains) for t in as_given]
    assert len(as_given) == 10 + 12


def test_a_twin_that_is_corrected_again_repeats_its_best_quarter(whole: Study) -> None:
    first, second = [event["twin"] for event in events(whole, "twin_version")][:2]
    of = {
        twin: [t for t in whole.trials if (t.source, t.twin, t.parent) == ("IS2", twin, None)]
        for twin in (first, second)
    }
    ranked = sorted(of[first], key=lambda t: ((t.late_error or 0.0) > 1.0, t.objective))
    quarter = ranked[: round(0.25 * len(ranked))]
    assert [t.gains for t in of[second]] == [t.gains for t in quarter]


def test_runs_made_again_are_no_queries(whole: Study) -> None:
    with Tuner(whole, method=replace(GMFBO_CALIBRATED, correction=OPTIONS)) as tuner:
        assert tuner.history.queries == 2
        current = {t.twin for t in tuner.history.state({}).trials if t.source != "IS1"}
        assert len(current) == 1


@pytest.mark.slow
def test_a_study_that_is_opened_anew_for_each_run_goes_on_the_same(
    whole: Study, tmp_path: Path
) -> None:
    study = study_in(tmp_path / "pieces")
    method = replace(GMFBO_CALIBRATED, correction=OPTIONS)
    for _ in range(6):
        with Tuner(study, method=method) as tuner:
            request = tuner.ask()
            if request is None:
                break
            real = next(t for t in whole.trials if t.number == request.number)
            assert dict(request.gains) == dict(real.gains)
            tuner.tell(request, real.recording)
    assert [(t.source, t.twin, t.objective) for t in study.trials] == [
        (t.source, t.twin, t.objective) for t in whole.trials
    ]


@contextmanager
def refining(study: Study, folder: Path) -> Iterator[tuple[FmuTwin, PhysicsRefiner, History]]:
    """The twin as a study is given it, and what corrects it anew from all of the study's runs."""
    given = FmuTwin(
        models_folder() / "drive_twin.toml", parameters={"map.noise": 0.5, "map.seed": 3.0}
    )
    with given, Tuner(study, method=replace(GMFBO_CALIBRATED, correction=OPTIONS)) as tuner:
        yield given, PhysicsRefiner(given, folder), tuner.history


def change_after_two_runs(history: History) -> None:
    """As if the watch had found it at the fourth."""
    last = history.of("IS1")[1].number
    history.drifts.append(Drift(4, 2, last, evidence=1e3, sign="lag", share=1.0))


def test_after_a_change_of_the_plant_the_twin_is_estimated_from_the_runs_since(
    whole: Study, tmp_path: Path
) -> None:
    with refining(whole, tmp_path) as (_, refiner, history):
        first = refiner.revise(history)
        assert first is not None
        assert first.reason == "estimated from 4 real runs"
        # Negative control: nothing is new.
        assert refiner.revise(history) is None
        change_after_two_runs(history)
        since = refiner.revise(history)
        assert since is not None
        assert since.reason == "estimated from 2 real runs"
        assert refiner.revise(history) is None


def asked_after_a_change(
    whole: Study, folder: Path, method: OnCorrectedTwin
) -> tuple[dict[str, float], dict[str, float]]:
    """What is asked when the plant is found to have changed, and the best gains of before."""
    with Tuner(study_in(folder, runs=5), method=method) as tuner:
        for made in [t for t in whole.trials if t.source == "IS1"]:
            request = tuner.ask()
            assert request is not None
            tuner.tell(request, made.recording, gains=request.gains, anyway=True)
        change_after_two_runs(tuner.history)
        request = tuner.ask()
        former = min(tuner.history.of("IS1")[:2], key=lambda trial: trial.objective)
    assert request is not None
    return dict(request.gains), dict(former.gains)


@pytest.mark.slow
def test_after_a_change_a_twin_of_the_changed_plant_spares_the_former_best_gains_a_run(
    whole: Study, tmp_path: Path
) -> None:
    estimates = replace(GMFBO_CALIBRATED, correction=OPTIONS)
    asked, former = asked_after_a_change(whole, tmp_path / "estimates", estimates)
    assert asked != former
    # Negative control: smoothing a table learns nothing from real runs.
    smooths = replace(SMOOTHED_ONCE, correction=OPTIONS)
    asked, former = asked_after_a_change(whole, tmp_path / "smooths", smooths)
    assert asked == former


def with_more_friction(trial: Trial) -> Trial:
    """A real run as the plant would have made it with four times the friction."""
    with FmuTwin(
        models_folder() / "drive_twin.toml", parameters={"friction.scale": 4.0}
    ) as changed:
        run = changed.run(trial.gains, replace(trial.recording, parameters={}))
    return replace(trial, recording=run)


def test_after_a_run_that_may_be_of_a_changed_plant_the_next_one_is_awaited(
    whole: Study, tmp_path: Path
) -> None:
    with refining(whole, tmp_path) as (_, refiner, history):
        third, fourth = history.of("IS1")[2:]
        history.trials = [trial for trial in history.trials if trial.number < fourth.number]
        first = refiner.revise(history)
        assert first is not None
        assert first.reason == "estimated from 3 real runs"
        history.trials.append(with_more_friction(fourth))
        assert refiner.revise(history) is None
        again = replace(with_more_friction(third), number=fourth.number + 1)
        history.trials.append(again)
        awaited = refiner.revise(history)
        assert awaited is not None
        assert awaited.reason == "estimated from 5 real runs"


@pytest.mark.slow
def test_a_run_that_may_be_of_a_changed_plant_is_not_mixed_with_those_before_it(
    tmp_path: Path,
) -> None:
    after = {}
    for name, scale in (("changed", 4.0), ("negative control", 1.0)):
        change = f'change = {{ after_runs = 3, parameters = {{ "friction.scale" = {scale} }} }}'
        study = study_in(tmp_path / name, runs=5, plant=change, shape="")
        with Tuner(study, method=replace(GMFBO_CALIBRATED, correction=OPTIONS)) as tuner:
            tuner.run()
            place = {trial.number: k for k, trial in enumerate(tuner.history.of("IS1"), 1)}
        after[name] = [place[event["after"]] for event in events(study, "twin_version")]
    assert 4 not in after["changed"]
    assert 5 in after["changed"]
    assert 4 in after["negative control"]


@pytest.mark.slow
def test_a_twin_that_was_taken_back_is_estimated_again_after_a_change_of_the_plant(
    whole: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with refining(whole, tmp_path) as (given, refiner, history):
        assert refiner.revise(history) is not None
        monkeypatch.setattr("gmfbo.retuning.refiner.misleads", lambda *_: True)
        back = refiner.revise(history)
        assert back is not None
        assert back.source is given
        # Negative control: the plant has not changed.
        assert refiner.revise(history) is None
        change_after_two_runs(history)
        since = refiner.revise(history)
        assert since is not None
        assert since.reason == "estimated from 2 real runs"


def test_a_diagnosis_is_not_told_what_the_plant_was_run_at(tmp_path: Path) -> None:
    study = study_in(tmp_path / "leak", runs=2, plant='parameters = { "friction.scale" = 2.0 }')
    with Tuner(study, method=replace(SMOOTHED_ONCE, correction=OPTIONS)) as tuner:
        tuner.run()
        real = tuner.history.of("IS1")
        # Negative control: the trial itself knows it.
        assert real[0].recording.parameters["friction.scale"] == 2.0
        with FmuTwin(models_folder() / "drive_twin.toml") as twin:
            told = plain_recordings(real, twin, tuner.history.experiment)
    for recording, trial in zip(told, real, strict=True):
        assert dict(recording.parameters) == dict(trial.gains)
        assert set(recording.signals) == {"reference", "position", "torque_command", "velocity"}


@dataclass
class Stubborn:
    """Corrects the twin once, to values that it is given."""

    twin: FmuTwin
    values: Mapping[str, float]
    done: bool = False

    def revise(self, history: History) -> TwinVersion | None:
        if self.done:
            return None
        self.done = True
        return TwinVersion(1, TwinAt(self.twin, self.values), "because")

    def restore(self, event: Mapping[str, Any]) -> TwinVersion:
        raise AssertionError("not resumed here")

    def close(self) -> None:
        """Nothing was opened."""


@pytest.mark.parametrize(
    ("values", "expected"),
    [({"load.inertia": 0.28, "friction.viscous": 1.0}, True), ({"map.noise": 0.0}, False)],
    ids=["a twin made worse", "negative control: the plant itself"],
)
def test_a_corrected_twin_that_predicts_worse_misleads(
    tmp_path: Path, values: dict[str, float], expected: bool
) -> None:
    study = study_in(tmp_path / "guard", runs=5, noise=0.1)
    method = OnCorrectedTwin(
        name="stubborn",
        summary="",
        reference="",
        searching=GMFBO_CALIBRATED.searching,
        refine=lambda twin, folder: Stubborn(twin, values),
        correction=OPTIONS,
    )
    with Tuner(study, method=method) as tuner:
        tuner.run()
        given = FmuTwin(
            models_folder() / "drive_twin.toml", parameters={"map.noise": 0.1, "map.seed": 3.0}
        )
        first = tuner.history.of("IS1")[1].number
        with given:
            assert misleads(tuner.history, given, first) is expected
