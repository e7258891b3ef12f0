"""A study begins with the real runs of an earlier one, or says in a line why it cannot."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gmfbo.errors import GmfboError, InputError, StudyFileError
from gmfbo.recordings.recording import Recording
from gmfbo.recordings.store.study_folder import StudyStore
from gmfbo.recordings.store.trial import Trial
from gmfbo.recordings.writing.writer import write_recording
from gmfbo.tuning.experiment.experiment_series import ExperimentSeries
from gmfbo.tuning.query.progress import Progress
from gmfbo.tuning.query.request import TuningResult
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.tuner import Tuner
from tests.tuning.analytic_axis import AnalyticAxis, write_study

OLD_BUDGET = "iterations = 4"
FROM = "[is1]", 'earlier = "../monday/axis.study"\n[is1]'


def tuned(study: Study, stop_at: int | None = None) -> TuningResult:
    """Run or continue a study; stopped as by Ctrl-C after a trial."""

    def watch(step: Progress) -> None:
        if step.trial == stop_at:
            raise KeyboardInterrupt

    with Tuner(study, is1=AnalyticAxis(), is2=AnalyticAxis(inertia=0.2, friction=0.4)) as tuner:
        return tuner.run(watch)


def edited(study: Study, *changes: tuple[str, str]) -> Study:
    """The study with other words in its file."""
    path = study.origin / "axis.toml"
    text = path.read_text(encoding="utf-8")
    for before, after in changes:
        assert before in text
        text = text.replace(before, after)
    path.write_text(text, encoding="utf-8")
    return Study.read(path)


def real(study: Study) -> list[Trial]:
    return [trial for trial in study.trials if trial.source == "IS1"]


@pytest.fixture
def monday(tmp_path: Path) -> Study:
    """Six real runs."""
    study = write_study(tmp_path / "monday", seed=1, budget=OLD_BUDGET)
    tuned(study)
    return study


def tuesday(
    tmp_path: Path, *changes: tuple[str, str], method: str = "random", budget: str = "is1_runs = 3"
) -> Study:
    """A study that names the earlier one."""
    new = write_study(tmp_path / "tuesday", seed=7, method=method, budget=budget)
    return edited(new, FROM, *changes)


def test_earlier_runs_come_first_with_their_signals_and_the_cost_of_the_new_study(
    tmp_path: Path, monday: Study
) -> None:
    study = tuesday(tmp_path)
    result = tuned(study)
    old, new = real(monday), real(study)
    assert len(old) == 6
    for before, after in zip(old, new, strict=False):
        assert after.gains == before.gains
        assert after.started == before.started
        np.testing.assert_array_equal(
            after.recording.signal("position"), before.recording.signal("position")
        )
        assert after.metrics == pytest.approx(before.metrics)
        assert study.objective is not None
        assert after.objective == pytest.approx(float(study.objective.value(before.metrics)))
    # Three runs were allowed and made, none of them an initial one: those were brought along.
    assert len(new) == 9
    assert (result.is1_runs, result.earlier, result.left_out) == (3, 6, 0)
    assert result.queries == 3
    assert result.cost == pytest.approx(3 + 0.1 * 10)


def test_proposals_learn_from_earlier_runs(tmp_path: Path, monday: Study) -> None:
    first = []
    for brought in (True, False):
        folder = tmp_path / f"{brought}"
        (folder / "monday").parent.mkdir(parents=True)
        (folder / "monday").symlink_to(tmp_path / "monday")
        study = tuesday(folder, method="bo_ei", budget="is1_runs = 1")
        if not brought:
            study = edited(study, ('earlier = "../monday/axis.study"\n', ""))
            study = edited(study, ("is1_runs = 1", "is1_runs = 1\ninitial_is1 = 1"))
        tuned(study)
        first.append(real(study)[-1].gains)
    least = min(real(monday), key=lambda trial: trial.objective)
    assert first[0] != first[1]
    assert first[0] != least.gains


@pytest.mark.parametrize("stop_at", [10, 13, 17])
def test_stopped_while_runs_are_taken_over_goes_on_as_if_not(
    tmp_path: Path, monday: Study, stop_at: int
) -> None:
    whole = tuesday(tmp_path)
    tuned(whole)
    expected = [(t.number, t.source, dict(t.gains), t.objective) for t in whole.trials]
    (tmp_path / "tuesday").rename(tmp_path / "whole")
    study = tuesday(tmp_path)
    with pytest.raises(KeyboardInterrupt):
        tuned(study, stop_at)
    # The earlier study goes on meanwhile; what was chosen stays chosen.
    tuned(edited(monday, (OLD_BUDGET, "iterations = 6")))
    tuned(study)
    assert [(t.number, t.source, dict(t.gains), t.objective) for t in study.trials] == expected


def test_a_study_that_took_all_runs_no_longer_needs_the_earlier_one(
    tmp_path: Path, monday: Study
) -> None:
    study = tuesday(tmp_path)
    tuned(study)
    monday.location.rename(tmp_path / "gone")
    result = tuned(edited(study, ("is1_runs = 3", "is1_runs = 4")))
    assert (result.is1_runs, result.earlier) == (4, 6)


def test_runs_outside_the_box_or_at_other_held_gains_are_left_out(
    tmp_path: Path, monday: Study
) -> None:
    middle = float(np.median([trial.gains["ctl.Kp"] for trial in real(monday)]))
    study = tuesday(tmp_path, ("[30.0, 200.0]", f"[30.0, {middle}]"))
    result = tuned(study)
    assert (result.earlier, result.left_out) == (3, 3)
    assert all(trial.gains["ctl.Kp"] <= middle for trial in real(study))


def test_a_longer_horizon_is_cut_and_scored_as_if_it_had_been_as_short(
    tmp_path: Path, monday: Study
) -> None:
    study = tuesday(tmp_path, ("horizon = 0.5", "horizon = 0.3"))
    with Tuner(study, is1=AnalyticAxis(), is2=AnalyticAxis()) as tuner:
        assert tuner.run().earlier == 6
        short = tuner.experiment
    for before, after in zip(real(monday), real(study), strict=False):
        again = AnalyticAxis().run(before.gains, short.reference)
        assert after.recording.time[-1] == pytest.approx(0.35)
        np.testing.assert_allclose(
            after.recording.signal("position"), again.signal("position"), rtol=0, atol=1e-12
        )
        assert dict(after.metrics) == pytest.approx(short.metrics(again))


def test_a_fixed_gain_may_become_free_and_a_free_one_fixed(tmp_path: Path) -> None:
    held = ('"ctl.Kd" = [2.0, 10.0]', '"ctl.Kd" = 4.0')
    monday = edited(write_study(tmp_path / "monday", seed=1, budget=OLD_BUDGET), held)
    tuned(monday)
    assert {trial.gains["ctl.Kd"] for trial in real(monday)} == {4.0}
    freed = tuned(tuesday(tmp_path))
    assert (freed.earlier, freed.left_out) == (6, 0)
    # The reverse: of runs at any stiffness those count that were made at the one now held.
    stiffness = real(monday)[2].gains["ctl.Kp"]
    fixed = edited(
        write_study(tmp_path / "wednesday", seed=3, budget="is1_runs = 2"),
        FROM,
        ("[30.0, 200.0]", repr(stiffness)),
    )
    result = tuned(fixed)
    assert (result.earlier, result.left_out) == (1, 5)
    assert result.why_left_out == (f"5: ctl.Kp is not {stiffness:g}, at which it is held",)


def test_a_box_that_grew_takes_all_runs(tmp_path: Path, monday: Study) -> None:
    result = tuned(tuesday(tmp_path, ("[30.0, 200.0]", "[10.0, 400.0]")))
    assert (result.earlier, result.left_out) == (len(real(monday)), 0)


FOLDER = "[is1]", 'earlier = "../logs"\n[is1]'


def logged(folder: Path, study: Study) -> list[dict[str, float]]:
    """Six recordings by hand, of which three can be taken; the gains of these."""
    folder.mkdir()
    with Tuner(study, is1=AnalyticAxis(), is2=AnalyticAxis()) as tuner:
        asked = tuner.experiment.reference
    half = replace(asked, signals={"reference": 0.5 * asked.signal("reference")})
    gains = [{"ctl.Kp": 60.0 + 20.0 * k, "ctl.Kd": 4.0 + k} for k in range(3)]
    runs = {f"run{k}.csv": AnalyticAxis().run(one, asked) for k, one in enumerate(gains)}
    runs |= {
        "soft.csv": AnalyticAxis().run({"ctl.Kp": 20.0, "ctl.Kd": 4.0}, asked),
        "half.csv": AnalyticAxis().run(gains[0], half),
        "unsaid.csv": replace(runs["run0.csv"], parameters={"ctl.Kp": 60.0}),
    }
    for name, run in runs.items():
        # A logger's clock begins anywhere.
        write_recording(replace(run, time=run.time + 100.0), folder / name)
    (folder / "README.md").write_text("what was measured\n")
    return gains


def test_a_folder_of_recordings_is_taken_over_and_what_is_not_is_listed(tmp_path: Path) -> None:
    study = write_study(tmp_path / "tuesday", seed=7, budget="is1_runs = 2")
    gains = logged(tmp_path / "logs", write_study(tmp_path / "other"))
    study = edited(study, FOLDER)
    result = tuned(study)
    assert (result.earlier, result.left_out, result.is1_runs) == (3, 3, 2)
    assert [dict(trial.gains) for trial in real(study)][:3] == gains
    reference = real(study)[0].recording
    for trial, made in zip(real(study), gains, strict=False):
        again = AnalyticAxis().run(made, reference)
        np.testing.assert_allclose(
            trial.recording.signal("position"), again.signal("position"), atol=1e-9
        )
    reasons = " ".join(result.why_left_out)
    assert "1: ctl.Kp lies outside [30, 200]" in reasons
    assert "1: ctl.Kd is not said" in reasons
    assert "its 'reference' goes from 0 to 0.5, but 0 to 1" in reasons
    # The choice stands in the log: the folder is no longer needed.
    (tmp_path / "logs").rename(tmp_path / "gone")
    assert tuned(edited(study, ("is1_runs = 2", "is1_runs = 3"))).earlier == 3


def test_a_folder_without_a_usable_recording_is_refused_in_one_line(tmp_path: Path) -> None:
    study = write_study(tmp_path / "tuesday", budget="is1_runs = 2")
    (tmp_path / "logs").mkdir()
    study = edited(study, FOLDER)
    with pytest.raises(StudyFileError, match="0 were made, none of them is; change"):
        tuned(study)
    assert not study.begun


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("[2.0, 10.0]", "[10.5, 12.0]"), r"6 were made, none of them is \(6: ctl.Kd lies outside"),
        (
            ('"ctl.Kd"', '"ctl.Ki" = [1.0, 2.0]\n"ctl.Kd"'),
            r"none of them is \(6: ctl.Ki is not said\)",
        ),
        (("step = 1.0", "step = 0.5"), "reference from 0 to 0.5 .*at 0.05 s, scored for 0.5 s"),
        (("horizon = 0.5", "horizon = 0.6"), "it played reference from 0 to 1 at 0.05 s, scored"),
        (("[budget]", '[objective]\nsignal = "speed"\n[budget]'), "expected the signal 'speed'"),
        (("../monday/axis.study", "axis.study"), "axis.study"),
        (("../monday/axis.study", "../sunday.study"), "sunday.study"),
    ],
)
def test_an_earlier_study_that_does_not_fit_is_refused_in_one_line_and_nothing_is_begun(
    tmp_path: Path, monday: Study, change: tuple[str, str], message: str
) -> None:
    study = tuesday(tmp_path, change)
    with pytest.raises(GmfboError, match=message) as refused:
        tuned(study)
    assert isinstance(refused.value, InputError)
    assert "\n" not in str(refused.value)
    assert not study.begun


def test_an_earlier_study_of_another_unit_is_refused(tmp_path: Path, monday: Study) -> None:
    moved = tmp_path / "linear.study"
    text = (monday.origin / "axis.toml").read_text(encoding="utf-8")
    with StudyStore.create(moved, text) as store:
        for trial in monday.trials:
            run = trial.recording
            metres = Recording(time=run.time, signals=dict(run.signals), units={"position": "m"})
            store.write_trial(replace(trial, recording=metres))
        store.log("begin", origin="../monday", twins={})
    (part,) = ExperimentSeries.from_sections(
        monday.file.references, "position", folder=monday.origin
    ).parts
    with_unit = replace(part.reference, units={"reference": "rad"})
    write_recording(with_unit, tmp_path / "reference.csv")
    study = tuesday(
        tmp_path,
        ("../monday/axis.study", "../linear.study"),
        (
            "step = 1.0\nat = 0.05\nhorizon = 0.5\nsample_time = 2e-3",
            'file = "../reference.csv"\nhorizon = 0.5',
        ),
    )
    with pytest.raises(
        StudyFileError, match="expected 'position' in rad, its trial 11 has it in m"
    ):
        tuned(study)


def test_another_earlier_study_cannot_be_named_later(tmp_path: Path, monday: Study) -> None:
    study = tuesday(tmp_path)
    tuned(study)
    with pytest.raises(StudyFileError, match=r"begun with another \[earlier\]"):
        tuned(edited(study, ("../monday/axis.study", "../monday/axis.toml")))
