"""A plant whose friction doubles while it is tuned: noticed, told, kept; and nothing otherwise."""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from gmfbo.cli.tuning.study_display import StudyDisplay
from gmfbo.errors import StudyFileError
from gmfbo.recordings.recording import Recording
from gmfbo.recordings.store.memory_store import MemoryStore
from gmfbo.recordings.store.pack import pack_study
from gmfbo.tuning.drift.drift import Drift
from gmfbo.tuning.drift_watch import DriftWatch
from gmfbo.tuning.history.state import TuningState
from gmfbo.tuning.query.progress import Progress
from gmfbo.tuning.query.request import TuningResult
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.tuner import Tuner
from tests.tuning.analytic_axis import AnalyticAxis, write_study
from tests.tuning.methods.quick_methods import QUICK

REPEATING = "is1_runs = {runs}\n[drift]\nrepeat_every = 3\n"
FOUND = Drift(found_at=3, after_runs=1, last_before=11, evidence=1e3, sign="cost", share=2.0)


@dataclass
class AgeingAxis(AnalyticAxis):
    """Its friction is multiplied for good after some runs."""

    factor: float = 2.0
    after: int = 4
    made_before: int = 0

    def run(self, gains: Mapping[str, float], reference: Recording) -> Recording:
        """Answer a step, with the friction of the day."""
        made = self.made_before + len(self.seen)
        today = replace(self, friction=self.friction * (self.factor if made >= self.after else 1.0))
        self.seen.append(dict(gains))
        return AnalyticAxis(today.inertia, today.friction).run(gains, reference)


def tuned(
    study: Study, factor: float, progress: Callable[[Progress], None] | None = None
) -> TuningResult:
    """Go on with a study of an axis whose friction changes after its fourth run."""
    made = sum(trial.source == "IS1" for trial in study.trials)
    axis = AgeingAxis(friction=1.5, factor=factor, made_before=made)
    twin, method = AnalyticAxis(inertia=0.2, friction=0.4), QUICK[study.file.method]
    with Tuner(study, is1=axis, is2=twin, method=method) as tuner:
        return tuner.run(progress)


def study_at(folder: Path, runs: int, sections: str = REPEATING, method: str = "random") -> Study:
    return write_study(folder, method=method, budget=sections.format(runs=runs))


def gains_of(study: Study) -> list[tuple[float, ...]]:
    return [tuple(t.gains.values()) for t in study.trials if t.source == "IS1"]


def test_doubled_friction_is_noticed_told_and_kept(tmp_path: Path) -> None:
    seen: list[Progress] = []
    study = study_at(tmp_path, 12)
    result = tuned(study, 2.0, seen.append)
    assert len(result.drifts) == 1
    (drift,) = result.drifts
    assert drift.after_runs in (3, 4, 5)
    told = [step.note for step in seen if step.phase == "drift"]
    assert told == [drift.message]
    assert f"changed after real run {drift.after_runs}" in told[0]
    assert study.drifts == result.drifts
    assert result.best is not None
    assert result.best.number > drift.last_before
    assert study.best is not None
    assert study.best.number == result.best.number
    packed = pack_study(study.location, tmp_path / "packed.h5")
    assert Study.read(packed).drifts == result.drifts


def test_the_same_study_that_does_not_watch_notices_nothing(tmp_path: Path) -> None:
    study = study_at(tmp_path, 12, REPEATING + "watch = false\n")
    assert tuned(study, 2.0).drifts == ()
    assert study.drifts == ()


def test_an_unchanged_plant_raises_no_alarm(tmp_path: Path) -> None:
    assert tuned(study_at(tmp_path, 12), 1.0).drifts == ()


def test_a_study_that_is_resumed_sees_the_same_changes_and_proposes_the_same(
    tmp_path: Path,
) -> None:
    whole = study_at(tmp_path / "whole", 12)
    tuned(whole, 2.0)
    for runs in (4, 8, 11, 12):
        parts = study_at(tmp_path / "parts", runs)
        tuned(parts, 2.0)
    assert whole.drifts
    assert parts.drifts == whole.drifts
    assert gains_of(parts) == gains_of(whole)


def test_after_a_change_the_former_best_is_run_again(tmp_path: Path) -> None:
    tuned(study_at(tmp_path, 4, "is1_runs = {runs}\n"), 1.0)
    longer = study_at(tmp_path, 5, "is1_runs = {runs}\n")
    with Tuner(longer, is1=AnalyticAxis(), is2=AnalyticAxis()) as tuner:
        real = tuner.history.of("IS1")
        former = min(real[:3], key=lambda trial: trial.objective)
        tuner.history.drifts.append(
            replace(FOUND, found_at=4, after_runs=3, last_before=real[2].number)
        )
        request = tuner.ask()
    assert request is not None
    assert request.gains == dict(former.gains)


@pytest.mark.parametrize(
    ("distance", "repeated"), [(0.01, False), (0.1, True)], ids=["next to it", "elsewhere"]
)
def test_the_former_best_is_not_run_again_where_a_run_since_was_next_to_it(
    tmp_path: Path, distance: float, repeated: bool
) -> None:
    study = study_at(tmp_path, 6, "is1_runs = {runs}\n")
    tuned(study, 1.0)
    with Tuner(study, is1=AnalyticAxis(), is2=AnalyticAxis()) as tuner:
        history, state = tuner.history, tuner.history.state({})
        real = history.of("IS1")
        best = min(real[:4], key=lambda trial: trial.objective)
        # The last run as if it had been made so far from the best one.
        place = history.unit_point(best.gains)
        moved = place + np.where(place < 0.5, distance, -distance) / np.sqrt(place.size)
        history.trials = [trial for trial in history.trials if trial is not real[-1]]
        history.trials.append(replace(real[-1], gains=history.gains_at(moved)))
        history.drifts.append(replace(FOUND, found_at=6, after_runs=4, last_before=real[3].number))
        repeat = DriftWatch(history, study.file.drift).former_best(state)
    assert (repeat is not None) is repeated
    assert repeat is None or repeat.gains == dict(best.gains)


@pytest.mark.parametrize("method", ["bo_ei", "gmfbo"])
def test_without_an_alarm_proposals_are_as_without_the_watch(tmp_path: Path, method: str) -> None:
    proposed = []
    for watch in ("true", "false"):
        sections = f"is1_runs = {{runs}}\n[drift]\nwatch = {watch}\n"
        study = study_at(tmp_path / watch, 3, sections, method)
        assert tuned(study, 1.0).drifts == ()
        proposed.append(gains_of(study))
    assert proposed[0] == proposed[1]


def test_every_third_run_repeats_the_best_of_the_first_two_where_the_study_wants_it(
    tmp_path: Path,
) -> None:
    study = study_at(tmp_path, 6)
    tuned(study, 1.0)
    real = [trial for trial in study.trials if trial.source == "IS1"]
    for place in (2, 5):
        best = min(real[:2], key=lambda trial: trial.objective)
        assert real[place].gains == best.gains


def state_after(folder: Path, drifts: list[Drift]) -> TuningState:
    """State of a study of four real runs, whose plant changed or not."""
    study = study_at(folder, 4, "is1_runs = {runs}\n", "gmfbo_paper")
    tuned(study, 1.0)
    with Tuner(study, is1=AnalyticAxis(), is2=AnalyticAxis()) as tuner:
        tuner.history.drifts.extend(drifts)
        return tuner.history.state({})


def test_older_real_runs_and_what_they_corrected_count_less_and_the_twin_does_not(
    tmp_path: Path,
) -> None:
    state = state_after(tmp_path, [])
    first = state.of("IS1")[0].number
    aged = state_after(tmp_path, [replace(FOUND, last_before=first)])
    assert [seen.outdated for seen in state.observations] == [0.0] * len(state.observations)
    for seen in aged.observations:
        old = seen.number == first or (seen.source == "IS3" and seen.parent == first)
        assert seen.outdated == (2.0 if old else 0.0)
    assert any(seen.source == "IS3" and seen.outdated for seen in aged.observations)
    assert aged.incumbent() == min(seen.objective for seen in aged.of("IS1")[1:])


@pytest.mark.parametrize(
    "method",
    [
        # Its acquisition function takes longest; its model is that of mfbo_caei.
        pytest.param(name, marks=pytest.mark.slow if name == "mfbo_takg" else ())
        for name in sorted(set(QUICK) - {"random", "twin_once"})
    ],
)
def test_every_method_goes_on_from_runs_that_count_less(tmp_path: Path, method: str) -> None:
    study = study_at(tmp_path, 2, "is1_runs = {runs}\n", method)
    chosen, store = QUICK[method], MemoryStore(study.location, study.text)
    with Tuner(
        study, is1=AnalyticAxis(), is2=AnalyticAxis(0.2), method=chosen, store=store
    ) as tuner:
        tuner.run()
        first = tuner.history.of("IS1")[0].number
        before = chosen.recommend(tuner.history.state({}))
        tuner.history.drifts.append(replace(FOUND, last_before=first, share=1e4))
        state = tuner.history.state({})
        proposal = chosen.propose(state, np.random.default_rng(0))
        after = chosen.recommend(state)
    assert proposal is not None
    assert np.all((proposal.point >= 0.0) & (proposal.point <= 1.0))
    assert (after[1], after[2]) != (before[1], before[2])


def test_the_change_is_printed_on_the_terminal() -> None:
    screen = Console(file=io.StringIO(), force_terminal=True, width=200, highlight=False)
    with StudyDisplay(screen, 12, 12) as display:
        display.show(
            Progress(
                phase="drift", iteration=1, iterations=9, is1_runs=3, trial=13, source="IS1",
                gains={"Kp": 1.0}, objective=0.5, status="ok", best_objective=0.5,
                best_gains={"Kp": 1.0}, mismatch=None, cost=4.0, seconds=1.0, seconds_left=None,
                note=FOUND.message,
            )
        )  # fmt: skip
    assert isinstance(screen.file, io.StringIO)
    assert "the plant has changed after real run 1" in screen.file.getvalue()


def test_repeating_every_run_is_refused(tmp_path: Path) -> None:
    with pytest.raises(StudyFileError, match=r"\[drift\] repeat_every: expected 0 or at least 2"):
        study_at(tmp_path, 3, "is1_runs = {runs}\n[drift]\nrepeat_every = 1\n")
