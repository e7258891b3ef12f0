"""Results measured beforehand: the nearest gains that are left, each recording once."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.errors import InputError, StudyFileError
from gmfbo.recordings.writing.writer import write_recording
from gmfbo.sources.plants.recorded_grid import RecordedGrid, RecordedRun
from gmfbo.space import Gain, GainSpace
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.study_file.gain_choice import GainChoice
from gmfbo.tuning.told.recorded_choice import RecordedChoice
from gmfbo.tuning.tuner import Tuner
from tests.tuning.analytic_axis import STUDY, AnalyticAxis
from tests.tuning.plants.plant_kinds import KINDS, REFERENCE

BOX = GainChoice(GainSpace((Gain("ctl.Kp", 30.0, 200.0), Gain("ctl.Kd", 2.0, 10.0))), {})
CORNERS = [(kp, kd) for kp in (30.0, 100.0, 200.0) for kd in (2.0, 10.0)]


def gains_of(kp: float, kd: float) -> dict[str, float]:
    return {"ctl.Kp": kp, "ctl.Kd": kd}


def record(folder: Path, name: str, kp: float, kd: float, *, named: bool = True) -> None:
    folder.mkdir(exist_ok=True)
    run = AnalyticAxis().run(gains_of(kp, kd), REFERENCE)
    write_recording(run if named else replace(run, parameters={}), folder / name)


def choice_of(points: list[tuple[float, float]]) -> RecordedChoice:
    runs = tuple(RecordedRun(gains_of(*point), None) for point in points)
    return RecordedChoice.within(RecordedGrid(Path("grid"), runs), BOX)


@given(st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0)))
def test_a_proposal_goes_to_the_nearest_recorded_gains(unit: tuple[float, float]) -> None:
    point = np.array(unit)
    chosen = choice_of(CORNERS).nearest(point, [], {})
    distance = {
        corner: np.linalg.norm(BOX.space.to_unit(np.array(corner)) - point) for corner in CORNERS
    }
    assert distance[chosen["ctl.Kp"], chosen["ctl.Kd"]] == pytest.approx(min(distance.values()))


@given(st.lists(st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0)), min_size=6, max_size=6))
def test_each_recording_is_asked_for_once(units: list[tuple[float, float]]) -> None:
    choice, played = choice_of(CORNERS), list[dict[str, float]]()
    for unit in units:
        assert not choice.used_up(played)
        played.append(choice.nearest(np.array(unit), played, {}))
    assert sorted(tuple(gains.values()) for gains in played) == sorted(CORNERS)
    assert choice.used_up(played)


def test_repeats_at_the_same_gains_come_one_after_the_other(tmp_path: Path) -> None:
    for number, height in enumerate((1.0, 2.0)):
        run = AnalyticAxis().run(gains_of(90.0, 4.0), REFERENCE)
        doubled = run.with_signals({"position": height * run.signal("position")})
        write_recording(doubled, tmp_path / f"run{number}.csv")
    grid, played = RecordedGrid.open(tmp_path), [gains_of(90.0, 4.0)]
    first = grid.after([]).run(played[0], REFERENCE).signal("position")
    second = grid.after(played).run(played[0], REFERENCE).signal("position")
    np.testing.assert_array_equal(second, 2.0 * first)
    with pytest.raises(InputError, match=r"nothing is left that was recorded at ctl\.Kp = 90"):
        grid.after(played * 2).run(played[0], REFERENCE)


def test_held_gains_are_held_on_the_grid(tmp_path: Path) -> None:
    choice = choice_of(CORNERS)
    assert choice.nearest(np.array([0.0, 0.0]), [], {"ctl.Kd": 10.0}) == gains_of(30.0, 10.0)
    with pytest.raises(InputError, match=r"no recording is left at ctl\.Kd = 5; hold another"):
        choice.nearest(np.array([0.0, 0.0]), [], {"ctl.Kd": 5.0})


def test_an_index_gives_the_gains_of_recordings_that_name_none(tmp_path: Path) -> None:
    grid = tmp_path / "grid"
    record(grid, "a.csv", 90.0, 4.0, named=False)
    (grid / "gains.csv").write_text(
        "recording,ctl.Kp,ctl.Kd\na.csv,90,4\n\n,180,2\n", encoding="utf-8"
    )
    opened = RecordedGrid.open(grid)
    assert [dict(run.gains) for run in opened.runs] == [gains_of(90.0, 4.0), gains_of(180.0, 2.0)]
    exact = AnalyticAxis().run(gains_of(90.0, 4.0), REFERENCE).signal("position")
    replayed = opened.run(gains_of(90.0, 4.0), REFERENCE).signal("position")
    np.testing.assert_array_equal(replayed, exact)
    failed = opened.run(gains_of(180.0, 2.0), REFERENCE)
    assert getattr(failed, "status", "ok") == "failed"


def test_a_study_ends_when_the_recordings_are_used_up(tmp_path: Path) -> None:
    (tmp_path / "axis.toml").write_text(
        STUDY.format(method="random", seed=0, budget="is1_runs = 20").replace(
            "ask_tell = true", 'recorded = "grid"'
        ),
        encoding="utf-8",
    )
    for number, (kp, kd) in enumerate([*CORNERS, (300.0, 2.0)]):
        record(tmp_path / "grid", f"{number}.csv", kp, kd)
    study = Study.read(tmp_path / "axis.toml")
    with Tuner(study, is2=AnalyticAxis()) as tuner:
        assert tuner.run().is1_runs == len(CORNERS)  # the one outside the box is not asked for
    asked = {tuple(t.gains.values()) for t in study.trials if t.source == "IS1"}
    assert asked == set(CORNERS)


def test_a_grid_that_changed_under_a_study_is_refused(tmp_path: Path) -> None:
    study = KINDS["recorded"].study(tmp_path / "s")
    Tuner(study, is2=AnalyticAxis()).close()
    record(study.origin / "grid", "one_more.csv", 77.0, 3.0)
    with pytest.raises(StudyFileError, match="IS1 has changed since the study was begun"):
        Tuner(study, is2=AnalyticAxis())


@pytest.mark.parametrize(
    ("index", "message"),
    [
        ("file,ctl.Kp\na.csv,90", "expected a first line such as 'recording,ctl.Kp,ctl.Kd'"),
        ("recording,ctl.Kp\na.csv,ninety", "line 2: expected a recording and 1 numbers"),
        ("recording,ctl.Kp\nb.csv,90", r"line 2: no recording 'b\.csv'; leave the cell blank"),
    ],
)
def test_a_wrong_index_is_refused_with_its_line(tmp_path: Path, index: str, message: str) -> None:
    record(tmp_path, "a.csv", 90.0, 4.0)
    (tmp_path / "gains.csv").write_text(index, encoding="utf-8")
    with pytest.raises(StudyFileError, match=message):
        RecordedGrid.open(tmp_path)


def test_a_folder_without_use_is_refused(tmp_path: Path) -> None:
    with pytest.raises(StudyFileError, match=r"recorded: no folder .*none; give one"):
        RecordedGrid.open(tmp_path / "none")
    with pytest.raises(StudyFileError, match="recorded: no recording in"):
        RecordedGrid.open(tmp_path)
    record(tmp_path, "a.csv", 90.0, 4.0, named=False)
    with pytest.raises(StudyFileError, match=r"a\.csv does not say at which 'ctl\.Kp' it was made"):
        RecordedChoice.within(RecordedGrid.open(tmp_path), BOX)
    with pytest.raises(StudyFileError, match="none of the 1 recordings in grid was made within"):
        choice_of([(10.0, 1.0)])
