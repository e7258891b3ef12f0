"""The loop on a plant in closed form: order, budget, failures, resume, fixed gains."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from gmfbo.errors import InputError, RecordingError, SimulationError, StoreError, StudyFileError
from gmfbo.objective.metrics import METRICS, worst_metrics
from gmfbo.recordings.recording import Recording, Trajectory
from gmfbo.recordings.store.memory_store import MemoryStore
from gmfbo.recordings.store.trial import Trial
from gmfbo.tuning.methods import METHODS
from gmfbo.tuning.query.progress import Progress
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.tuner import Tuner
from tests.tuning.analytic_axis import AnalyticAxis, write_study
from tests.tuning.methods.quick_methods import QUICK


def wrong_twin(failing: frozenset[int] = frozenset()) -> AnalyticAxis:
    return AnalyticAxis(inertia=0.2, friction=0.4, failing=failing)


def tuner_of(study: Study) -> Tuner:
    return Tuner(study, is1=AnalyticAxis(), is2=wrong_twin())


def gains_of(study: Study, source: str) -> list[tuple[float, ...]]:
    return [tuple(t.gains.values()) for t in study.trials if t.source == source]


def test_a_study_runs_initial_data_first_and_ends_with_its_budget(tmp_path: Path) -> None:
    study = write_study(tmp_path, budget="iterations = 3\ninitial_is1 = 2\ninitial_is2 = 10")
    with tuner_of(study) as tuner:
        result = tuner.run()
    assert [trial.source for trial in study.trials] == ["IS2"] * 10 + ["IS1"] * 5
    assert [trial.number for trial in study.trials] == list(range(1, 16))
    assert (result.is1_runs, result.queries) == (5, 3)
    assert result.cost == pytest.approx(5 + 0.1 * 10)


def test_best_is_the_least_cost_among_real_runs(tmp_path: Path) -> None:
    study = write_study(tmp_path, budget="iterations = 6")
    with tuner_of(study) as tuner:
        result = tuner.run()
    costs = [trial.objective for trial in study.trials if trial.source == "IS1"]
    assert result.best is not None
    assert result.best.objective == min(costs)
    assert study.best is not None
    assert study.best.number == result.best.number
    assert result.recommendation == study.recommendation


def test_costs_follow_from_the_constants_of_the_initial_twin_runs(tmp_path: Path) -> None:
    study = write_study(tmp_path)
    with tuner_of(study) as tuner:
        tuner.run()
    initial = [t for t in study.trials if t.source == "IS2"]
    assert np.mean([t.objective for t in initial]) == pytest.approx(0.0, abs=1e-12)
    assert study.objective is not None
    for trial in study.trials:
        assert trial.objective == pytest.approx(float(study.objective.value(trial.metrics)))


def test_a_budget_of_real_runs_counts_the_initial_ones(tmp_path: Path) -> None:
    study = write_study(tmp_path, budget="is1_runs = 5")
    with tuner_of(study) as tuner:
        assert tuner.run().is1_runs == 5


def trials_of(folder: Path, method: str, seed: int, iterations: int) -> list[Trial]:
    """Trials of a study that is kept in memory, where a disk would take most of the time."""
    study = write_study(folder, method=method, seed=seed, budget=f"iterations = {iterations}")
    store = MemoryStore(study.location, study.text)
    chosen = QUICK[method]
    with Tuner(study, is1=AnalyticAxis(), is2=wrong_twin(), method=chosen, store=store) as tuner:
        tuner.run()
    return store.trials()


def initial_data(folder: Path, method: str) -> list[tuple[dict[str, float], float]]:
    trials = trials_of(folder, method, 3, 0)
    twin = [t for t in trials if t.source == "IS2" and t.parent is None][:10]
    real = [t for t in trials if t.source == "IS1"]
    return [(dict(t.gains), t.objective) for t in (*twin, *real)]


@pytest.fixture(scope="module")
def initial_data_of_random(
    tmp_path_factory: pytest.TempPathFactory,
) -> list[tuple[dict[str, float], float]]:
    return initial_data(tmp_path_factory.mktemp("random"), "random")


@pytest.mark.parametrize("method", sorted(set(METHODS) - {"random"}))
def test_every_method_starts_from_the_same_data(
    tmp_path: Path, method: str, initial_data_of_random: list[tuple[dict[str, float], float]]
) -> None:
    seen = initial_data(tmp_path, method)
    assert seen == initial_data_of_random
    assert len(seen) == 12


def test_the_same_seed_gives_the_same_study(tmp_path: Path) -> None:
    # Of every method: tests/tuning/methods/test_method_contract.py, where the second is reopened.
    twice = [
        [(t.source, dict(t.gains), t.objective) for t in trials_of(tmp_path / name, "bo_ei", 5, 2)]
        for name in ("a", "b")
    ]
    assert twice[0] == twice[1]


def test_memory_and_disk_make_the_same_study(tmp_path: Path) -> None:
    study = write_study(tmp_path / "disk", method="gmfbo_paper", seed=5, budget="iterations = 2")
    with tuner_of(study) as tuner:
        tuner.run()
    for kept, trial in zip(
        study.trials, trials_of(tmp_path / "memory", "gmfbo_paper", 5, 2), strict=True
    ):
        assert (kept.number, kept.source, kept.parent) == (
            trial.number,
            trial.source,
            trial.parent,
        )
        assert (kept.gains, kept.objective) == (trial.gains, trial.objective)


def test_a_survey_of_the_twin_is_recorded_but_is_no_query(tmp_path: Path) -> None:
    study = write_study(tmp_path, method="gmfbo", budget="iterations = 0")
    correction = QUICK["gmfbo"].correction
    assert correction is not None
    assert correction.survey > 0
    with Tuner(study, is1=AnalyticAxis(), is2=wrong_twin(), method=QUICK["gmfbo"]) as tuner:
        result = tuner.run()
    surveyed = [t for t in study.trials if t.source == "IS2" and t.parent is None]
    assert len(surveyed) == 10 + correction.survey
    assert len({tuple(t.gains.values()) for t in surveyed}) == len(surveyed)
    assert result.queries == 0
    assert result.cost == pytest.approx(2 + 0.1 * (len(study.trials) - 2))


def test_another_seed_gives_another_study(tmp_path: Path) -> None:
    firsts = []
    for seed in (1, 2):
        study = write_study(tmp_path / str(seed), seed=seed, budget="iterations = 0")
        with tuner_of(study) as tuner:
            tuner.run()
        firsts.append(study.trials[0].gains)
    assert firsts[0] != firsts[1]


def test_failed_runs_are_priced_and_recorded_and_end_nothing(tmp_path: Path) -> None:
    study = write_study(tmp_path, method="bo_ei", budget="iterations = 3")
    twin = wrong_twin(failing=frozenset({2, 7}))
    plant = AnalyticAxis(failing=frozenset({1, 4}))
    with Tuner(study, is1=plant, is2=twin) as tuner:
        result = tuner.run()
    failed = [trial for trial in study.trials if trial.status != "ok"]
    assert [trial.source for trial in failed] == ["IS2", "IS2", "IS1", "IS1"]
    assert study.objective is not None
    for trial in failed:
        steps = {name: trial.metrics[name] for name in METRICS}
        assert steps == worst_metrics(0.5)
        assert trial.metrics["itae"] == study.objective.worst["itae"]
        assert trial.objective == pytest.approx(study.objective.failed)
        assert isinstance(trial.recording, Trajectory)
        assert trial.recording.message == "the axis lost its encoder"
    assert result.is1_runs == 5
    assert result.best is not None
    assert result.best.status == "ok"


def test_a_bug_in_a_users_plant_costs_a_run_and_is_named(tmp_path: Path) -> None:
    class Broken(AnalyticAxis):
        def run(self, gains: Mapping[str, float], reference: Recording) -> Recording:
            raise KeyError("torque")

    study = write_study(tmp_path, budget="iterations = 0")
    with Tuner(study, is1=Broken(), is2=AnalyticAxis()) as tuner:
        result = tuner.run()
    assert result.best is None
    broken = study.trials[-1].recording
    assert isinstance(broken, Trajectory)
    assert broken.message == "KeyError('torque')"


def test_a_twin_that_never_succeeds_ends_the_study_before_a_real_run(tmp_path: Path) -> None:
    twin, plant = AnalyticAxis(failing=frozenset(range(1, 11))), AnalyticAxis()
    with (
        Tuner(write_study(tmp_path), is1=plant, is2=twin) as tuner,
        pytest.raises(SimulationError, match="none of the 10 initial runs of IS2 succeeded"),
    ):
        tuner.run()
    assert plant.seen == []


def test_a_held_gain_keeps_its_value(tmp_path: Path) -> None:
    for method in ("random", "bo_ei"):
        study = write_study(tmp_path / method, method=method, budget="iterations = 3")
        with tuner_of(study) as tuner:
            plant = AnalyticAxis()
            while (request := tuner.ask(fixed={"ctl.Kd": 3.0})) is not None:
                assert request.gains["ctl.Kd"] == 3.0
                tuner.tell(request, plant.run(request.gains, tuner.experiment.reference))
        assert len({gains[0] for gains in gains_of(study, "IS1")}) == 5


def test_all_gains_held_are_asked_for_as_they_are(tmp_path: Path) -> None:
    study = write_study(tmp_path, method="bo_ei", budget="iterations = 3\ninitial_is1 = 1")
    with tuner_of(study) as tuner:
        request = tuner.ask()
        assert request is not None
        plant = AnalyticAxis()
        tuner.tell(request, plant.run(request.gains, tuner.experiment.reference))
        held = {"ctl.Kp": 100.0, "ctl.Kd": 5.0}
        request = tuner.ask(fixed=held)
        assert request is not None
        assert request.gains == held


def test_a_held_gain_outside_its_range_is_refused(tmp_path: Path) -> None:
    with (
        tuner_of(write_study(tmp_path)) as tuner,
        pytest.raises(InputError, match=r"'ctl\.Kd' within \[2, 10\], got 50"),
    ):
        tuner.ask(fixed={"ctl.Kd": 50.0})


def test_asking_again_gives_the_same_request_also_after_a_restart(tmp_path: Path) -> None:
    study = write_study(tmp_path, method="bo_ei")
    with tuner_of(study) as tuner:
        first = tuner.ask()
        assert tuner.ask() == first
    with tuner_of(study) as tuner:
        assert tuner.pending == first
        assert tuner.ask() == first


def test_telling_what_was_not_asked_is_refused(tmp_path: Path) -> None:
    study, plant = write_study(tmp_path), AnalyticAxis()
    with tuner_of(study) as tuner:
        request = tuner.ask()
        assert request is not None
        run = plant.run(request.gains, tuner.experiment.reference)
        with pytest.raises(InputError, match="trial 99 is not waited for: trial 11 is"):
            tuner.tell(99, run)
        tuner.tell(request, run)
        with pytest.raises(InputError, match="trial 11 is not waited for: none is"):
            tuner.tell(request, run)


def test_a_recording_at_other_gains_is_refused_and_can_be_told_right(tmp_path: Path) -> None:
    study, plant = write_study(tmp_path), AnalyticAxis()
    with tuner_of(study) as tuner:
        request = tuner.ask()
        assert request is not None
        reference = tuner.experiment.reference
        other = plant.run({**request.gains, "ctl.Kd": 9.5}, reference)
        with pytest.raises(RecordingError, match=r"made with ctl\.Kd = 9\.5, but trial 11 asks"):
            tuner.tell(request, other)
        assert tuner.tell(request, plant.run(request.gains, reference)).number == 11


def test_running_a_plant_that_somebody_else_runs_is_refused(tmp_path: Path) -> None:
    with (
        Tuner(write_study(tmp_path), is2=AnalyticAxis()) as tuner,
        pytest.raises(InputError, match="somebody else runs this plant"),
    ):
        tuner.run()


def test_sources_handed_in_stay_open(tmp_path: Path) -> None:
    plant, twin = AnalyticAxis(), AnalyticAxis()
    Tuner(write_study(tmp_path), is1=plant, is2=twin).close()
    assert not plant.closed
    assert not twin.closed


def test_progress_reports_every_run(tmp_path: Path) -> None:
    seen: list[Progress] = []
    study = write_study(tmp_path, budget="iterations = 3")
    with tuner_of(study) as tuner:
        tuner.run(seen.append)
    phases = [event.phase for event in seen]
    assert phases == ["initial"] * 12 + ["query"] * 3 + ["done"]
    assert [event.iteration for event in seen[-4:]] == [1, 2, 3, 3]
    assert [event.trial for event in seen[:-1]] == list(range(1, 16))
    best = [event.best_objective for event in seen if event.best_objective is not None]
    assert best == sorted(best, reverse=True)
    assert seen[-1].seconds_left == 0.0
    assert seen[-1].cost == pytest.approx(6.0)


def test_a_finished_study_is_not_run_again(tmp_path: Path) -> None:
    study = write_study(tmp_path, budget="iterations = 2")
    with tuner_of(study) as tuner:
        tuner.run()
    before = [trial.number for trial in study.trials]
    with tuner_of(study) as tuner:
        tuner.run()
    assert [trial.number for trial in study.trials] == before


def test_a_longer_budget_goes_on_as_if_it_had_been_given_at_first(tmp_path: Path) -> None:
    short = write_study(tmp_path / "a", method="bo_ei", budget="iterations = 2")
    with tuner_of(short) as tuner:
        tuner.run()
    longer = write_study(tmp_path / "a", method="bo_ei", budget="iterations = 4")
    with tuner_of(longer) as tuner:
        tuner.run()
    at_once = write_study(tmp_path / "b", method="bo_ei", budget="iterations = 4")
    with tuner_of(at_once) as tuner:
        tuner.run()
    assert gains_of(longer, "IS1") == gains_of(at_once, "IS1")


def test_a_study_that_was_begun_is_not_begun_again_without_resume(tmp_path: Path) -> None:
    study = write_study(tmp_path)
    with tuner_of(study) as tuner:
        tuner.run()
    with pytest.raises(StoreError, match="holds 16 trials already; go on with them by --resume"):
        Tuner(study, is1=AnalyticAxis(), is2=AnalyticAxis(), resume=False)


def test_a_study_is_not_continued_with_another_file(tmp_path: Path) -> None:
    with tuner_of(write_study(tmp_path, method="random")) as tuner:
        tuner.run()
    with pytest.raises(StudyFileError, match=r"begun with another \[seed\]"):
        tuner_of(write_study(tmp_path, method="random", seed=8))


def test_a_study_is_not_continued_with_another_twin(tmp_path: Path) -> None:
    study = write_study(tmp_path)
    with Tuner(study, is1=AnalyticAxis(), is2=AnalyticAxis(content_hash="one")) as tuner:
        tuner.run()
    with pytest.raises(StudyFileError, match="the twin of IS2 has changed since"):
        Tuner(study, is1=AnalyticAxis(), is2=AnalyticAxis(content_hash="two"))


def test_an_interrupt_keeps_what_was_finished(tmp_path: Path) -> None:
    class Interrupted(AnalyticAxis):
        def run(self, gains: Mapping[str, float], reference: Recording) -> Recording:
            if len(self.seen) == 3:
                raise KeyboardInterrupt
            return super().run(gains, reference)

    study = write_study(tmp_path, budget="iterations = 6")
    with (
        Tuner(study, is1=Interrupted(), is2=wrong_twin()) as tuner,
        pytest.raises(KeyboardInterrupt),
    ):
        tuner.run()
    assert len(gains_of(study, "IS1")) == 3
    with tuner_of(study) as tuner:
        assert tuner.run().is1_runs == 8
    whole = write_study(tmp_path / "whole", budget="iterations = 6")
    with tuner_of(whole) as tuner:
        tuner.run()
    assert gains_of(study, "IS1") == gains_of(whole, "IS1")


def test_a_study_reads_from_its_folder_as_from_its_file(tmp_path: Path) -> None:
    study = write_study(tmp_path, budget="iterations = 2")
    assert study.trials == ()
    assert study.best is None
    with tuner_of(study) as tuner:
        tuner.run()
    again = Study.read(study.location)
    assert again.file == study.file
    assert again.origin.resolve() == study.origin.resolve()
    assert repr(again) == repr(study)
    assert repr(again).startswith("<Study 'axis': random, seed 0, 4 IS1, 10 IS2, 0 IS3 runs, best")


def test_an_unknown_method_is_refused_with_the_nearest(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no method 'bo_ie'; did you mean 'bo_ei'\?"):
        tuner_of(write_study(tmp_path, method="bo_ie"))
