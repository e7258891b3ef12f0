"""The twin is run around the promising gains before each query."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gmfbo.recordings.store.memory_store import MemoryStore
from gmfbo.recordings.store.trial import Trial
from gmfbo.tuning.methods.gmfbo import CORRECTION, Gmfbo
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.tuner import Tuner
from gmfbo.tuning.twin.closer_look import RADII
from tests.tuning.analytic_axis import AnalyticAxis, write_study

EACH = 3
COUNT = 2 * EACH  # in a stage, of two gains
AROUND = 4  # `is3_per_run` of the study
METHOD = Gmfbo(correction=replace(CORRECTION, survey=25, closer=EACH))


def played(folder: Path, closer: int, iterations: int = 2) -> list[Trial]:
    method = Gmfbo(correction=replace(CORRECTION, survey=25, closer=closer))
    study = write_study(folder, method="gmfbo", budget=f"iterations = {iterations}")
    store = MemoryStore(study.location, study.text)
    twin = AnalyticAxis(inertia=0.2)
    with Tuner(study, is1=AnalyticAxis(), is2=twin, method=method, store=store) as tuner:
        tuner.run()
        return store.trials()


def looks(trials: list[Trial]) -> list[list[Trial]]:
    """Runs of the twin that belong to each real run, but those beside it and right around it."""
    real = [trial for trial in trials if trial.source == "IS1"]
    return [
        [t for t in trials if (t.source, t.parent) == ("IS2", one.number) and t.gains != one.gains][
            AROUND:
        ]
        for one in real
    ]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Study:
    """A study on the disk, of which each test breaks a copy."""
    study = write_study(
        tmp_path_factory.mktemp("look") / "whole", method="gmfbo", budget="iterations = 2"
    )
    tuned(study)
    return study


def tuned(study: Study) -> None:
    with Tuner(study, is1=AnalyticAxis(), is2=AnalyticAxis(inertia=0.2), method=METHOD) as tuner:
        tuner.run()


def test_each_query_is_preceded_by_two_stages_around_few_places(whole: Study) -> None:
    trials = list(whole.trials)
    with Tuner(whole, is1=AnalyticAxis(), is2=AnalyticAxis(inertia=0.2), method=METHOD) as tuner:
        history = tuner.history
    # The first initial run asks for nothing, and after the last query there is none to prepare.
    assert [len(look) for look in looks(trials)] == [0, 2 * COUNT, 2 * COUNT, 0]
    for look in looks(trials)[1:3]:
        points = np.array([history.unit_point(trial.gains) for trial in look])
        assert points.min() >= 0.0
        assert points.max() <= 1.0
        for stage, radius in enumerate(RADII):
            # Turn about, the draws lie around one promising place and the other.
            for centre in range(2):
                near = points[stage * COUNT + centre : (stage + 1) * COUNT : 2]
                spread = np.linalg.norm(near - np.median(near, axis=0), axis=1)
                assert spread.max() < 8.0 * radius


def test_what_a_closer_look_found_may_be_asked_for(tmp_path: Path) -> None:
    trials = played(tmp_path, EACH, iterations=4)
    looked_at = [tuple(trial.gains.values()) for look in looks(trials) for trial in look]
    asked = [tuple(trial.gains.values()) for trial in trials if trial.source == "IS1"]
    assert set(asked[2:]) & set(looked_at)


def test_negative_control_without_it_there_are_no_such_runs(tmp_path: Path) -> None:
    trials = played(tmp_path, 0)
    assert [len(look) for look in looks(trials)] == [0, 0, 0, 0]


@pytest.mark.parametrize("kept", [1, COUNT, COUNT + 2])
def test_a_look_that_was_broken_off_goes_on_to_the_same_runs(
    tmp_path: Path, whole: Study, kept: int
) -> None:
    expected = whole.trials
    first = looks(list(expected))[1][kept - 1].number  # the last run that survived
    shutil.copytree(whole.origin, tmp_path / "broken")
    study = Study.read(tmp_path / "broken" / "axis.toml")
    for path in (study.location / "trials").glob("*.h5"):
        if int(path.stem) > first:
            path.unlink()
    log = study.location / "events.jsonl"
    lines = log.read_text(encoding="utf-8").splitlines(keepends=True)
    asked = [k for k, line in enumerate(lines) if '"ask"' in line]
    log.write_text("".join(lines[: asked[2]]), encoding="utf-8")  # two initial runs were asked for
    tuned(study)
    assert [(t.source, t.gains) for t in study.trials] == [(t.source, t.gains) for t in expected]
