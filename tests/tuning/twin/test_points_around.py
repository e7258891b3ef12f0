"""Runs of the twin around a real run: candidates of the next query, corrected or not."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from gmfbo.recordings.store.study_folder import StudyStore
from gmfbo.recordings.store.trial import Trial
from gmfbo.tuning.methods.gmfbo import CORRECTION, Gmfbo
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.tuner import Tuner
from tests.tuning.analytic_axis import AnalyticAxis, write_study

METHOD = Gmfbo(correction=replace(CORRECTION, survey=25, closer=4))
BEGUN_AS = "gmfbo.tuning.study.study.OBJECTIVE_VERSION"


def tuned(folder: Path, seed: int, budget: str = "iterations = 4") -> Study:
    study = write_study(folder, method="gmfbo", seed=seed, budget=budget)
    go_on(study)
    return study


def go_on(study: Study) -> None:
    with Tuner(study, is1=AnalyticAxis(), is2=AnalyticAxis(inertia=0.2), method=METHOD) as tuner:
        tuner.run()


def of(study: Study, source: str) -> list[Trial]:
    return [trial for trial in study.trials if trial.source == source]


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_proposals_are_the_same_with_and_without_the_correction(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, seed: int
) -> None:
    plain = tuned(tmp_path / "plain", seed)
    monkeypatch.setattr(BEGUN_AS, 2)
    corrected = tuned(tmp_path / "corrected", seed)
    asked = [[dict(t.gains) for t in of(study, "IS1")] for study in (plain, corrected)]
    assert asked[0] == asked[1]
    assert plain.recommendation == corrected.recommendation
    assert (len(of(plain, "IS3")), len(of(corrected, "IS3"))) == (0, 6 * 4)
    assert len(of(plain, "IS2")) == len(of(corrected, "IS2")) + 6 * 4


def test_control_without_runs_around_real_ones_other_gains_are_asked_for(tmp_path: Path) -> None:
    # On which seeds the candidates around a real run win is chance: one of three is enough.
    differ = []
    for seed in range(3):
        some = tuned(tmp_path / f"some{seed}", seed)
        none = tuned(tmp_path / f"none{seed}", seed, "iterations = 4\nis3_per_run = 0")
        asked = [[dict(t.gains) for t in of(study, "IS1")] for study in (some, none)]
        differ.append(asked[0] != asked[1])
    assert any(differ)


@pytest.mark.slow
def test_a_study_begun_before_goes_on_with_corrected_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as former:
        former.setattr(BEGUN_AS, 2)
        study = tuned(tmp_path, 0, "iterations = 1")
    path = study.origin / "axis.toml"
    path.write_text(path.read_text().replace("iterations = 1", "iterations = 2"))
    go_on(Study.read(path))
    real, corrected = of(study, "IS1"), of(study, "IS3")
    assert {trial.parent for trial in corrected} == {trial.number for trial in real}
    with StudyStore.open(study.location) as store:
        fitted = [event for event in store.events() if event["event"] == "correction"]
    assert len(fitted) == len(real)


def test_no_correction_is_fitted_where_no_proposal_depends_on_it(tmp_path: Path) -> None:
    study = tuned(tmp_path, 0, "iterations = 1")
    with StudyStore.open(study.location) as store:
        events = store.events()
    assert not [event for event in events if event["event"] == "correction"]
    # The mismatch of the twin is told all the same, by the real runs and the twin beside them.
    (asked,) = [e["mismatch"] for e in events if e["event"] == "ask" and e["mismatch"] is not None]
    assert asked > 0.0
