"""Comparisons on plants that are no FMU, and judging without noise."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import numpy as np
import pytest

from gmfbo import Study, compare
from gmfbo.errors import InputError, StudyFileError
from gmfbo.space import Gain, GainSpace
from gmfbo.studies.given_truth import GivenTruth
from gmfbo.studies.plant_grid import TrueSources
from tests.studies.small_study import write_small_study

GRID = 7

PLANT = """
import csv, json, sys
from pathlib import Path

import numpy as np

def response(gains, time, step_at, step):
    rate = gains["kp"] * gains["kv"] / (gains["kv"] + 200.0)
    return step * (1.0 - np.exp(-rate * np.maximum(time - step_at, 0.0)))

def plant(gains, reference):
    wanted = reference.signals["reference"]
    at = reference.time[int(np.argmax(wanted > 0.0))]
    return {"time": reference.time, "position": response(gains, reference.time, at, wanted[-1])}

if __name__ == "__main__":
    asked = json.loads(Path(sys.argv[sys.argv.index("--request") + 1]).read_text())
    rows = [row for row in csv.reader(Path(asked["reference"]).open()) if row[0][0] != "#"][1:]
    time, wanted = np.array(rows, dtype=float).T[:2]
    position = response(asked["gains"], time, time[int(np.argmax(wanted > 0.0))], wanted[-1])
    with open(asked["out"], "w") as file:
        print("time,position", file=file)
        for pair in zip(time, position):
            print("%.9g,%.9g" % pair, file=file)
"""
METRICS = ("overshoot", "transient_time", "rise_time", "settling_time")


def own_plant(folder: Path, kind: str, truth: str = "truth.csv") -> Path:
    """A study whose plant is a file of Python, with the exact truth of its rise time."""
    (folder / "plant.py").write_text(PLANT, encoding="utf-8")
    study = write_small_study(folder)
    text = study.read_text(encoding="utf-8")
    axis = re.search(r'\[is1\]\n(twin = ".*")', text)
    assert axis is not None
    text = text.replace(axis[1], kind, 1) + f'[compare]\ntruth = "{truth}"\n'
    study.write_text(text, encoding="utf-8")
    box = re.search(r'"(.*linear_axis.toml)"', text)
    assert box is not None
    (kp, kv) = _box(Path(box[1]))
    points = [(x, y) for x in np.linspace(*kp, 7) for y in np.linspace(*kv, 7)]
    rows = [",".join(["kp", "kv", *METRICS])]
    rows += [f"{x},{y},0,0.3,{2.2 * (y + 200.0) / (x * y)},0.3" for x, y in points]
    (folder / "truth.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    return study


def _box(twin: Path) -> list[tuple[float, float]]:
    from gmfbo.sources.twin.twin import FmuTwin

    with FmuTwin(twin) as opened:
        assert opened.gains.names == ("kp", "kv")
        low, high = opened.gains.bounds
    return list(zip(low.tolist(), high.tolist(), strict=True))


@pytest.mark.parametrize(
    "kind",
    [f"command = ['{sys.executable}', 'plant.py']", 'function = "plant.py:plant"'],
    ids=["command", "function"],
)
def test_a_plant_that_is_no_fmu_is_judged_by_the_table(tmp_path: Path, kind: str) -> None:
    study = own_plant(tmp_path, kind)
    found = compare(study, ["random"], seeds=1, grid=GRID, out=tmp_path / "out")
    assert not found.failed
    (outcome,) = found.outcomes
    assert len(outcome.best) == 5
    assert outcome.regret[-1] >= 0.0
    assert outcome.least < outcome.median
    assert not list((tmp_path / "out" / "truth").glob("*.csv"))
    # The program is part of what the runs share.
    (tmp_path / "plant.py").write_text(PLANT + "\n# changed\n", encoding="utf-8")
    with pytest.raises(Exception, match="another study"):
        compare(study, ["random"], seeds=1, grid=GRID, out=tmp_path / "out")


def test_without_a_table_such_a_plant_is_refused_with_both_ways_out(tmp_path: Path) -> None:
    study = own_plant(tmp_path, 'function = "plant.py:plant"')
    text = study.read_text(encoding="utf-8")
    study.write_text(text.partition("[compare]")[0], encoding="utf-8")
    with pytest.raises(StudyFileError, match=r"expected twin = FILE.*or \[compare\] truth = FILE"):
        compare(study, ["random"], seeds=1, out=tmp_path / "out")


def test_who_asks_and_tells_is_not_compared(tmp_path: Path) -> None:
    study = own_plant(tmp_path, "ask_tell = true")
    with pytest.raises(StudyFileError, match="run by themselves"):
        compare(study, ["random"], seeds=1, out=tmp_path / "out")


SPACE = GainSpace((Gain("a", 0.0, 1.0), Gain("b", 1.0, 100.0, "log")))


def table(folder: Path, rows: list[str], head: str = "a,b,itae,late_error") -> Path:
    path = folder / "t.csv"
    path.write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")
    return path


def test_the_nearest_row_judges_in_the_scale_of_the_gains(tmp_path: Path) -> None:
    rows = [f"0.5,{10.0 ** (k / 5)},{k},0.5" for k in range(11)]
    truth = GivenTruth.read(table(tmp_path, rows), SPACE, frozenset({"itae"}))
    at = SPACE.to_unit(np.array([[0.4, 10.0 ** (k / 5 + 0.05)] for k in range(10)]))
    np.testing.assert_array_equal(truth.at(at)["itae"], np.arange(10))


def test_rows_that_did_not_settle_or_failed_are_infinite(tmp_path: Path) -> None:
    rows = [f"0.{k},10,{k},{'1.5' if k == 3 else '0.1'}" for k in range(9)] + ["0.95,10,nan,0"]
    truth = GivenTruth.read(table(tmp_path, rows), SPACE, frozenset({"itae"}))
    assert np.flatnonzero(np.isinf(truth.metrics["itae"])).tolist() == [3, 9]


@pytest.mark.parametrize(
    ("rows", "head", "said"),
    [
        (["0.5,10,1"] * 12, "a,b,rise_time", "has no column itae"),
        (["0.5,200,1"] * 12, "a,b,itae", "outside the box"),
        (["0.5,10,1"] * 3, "a,b,itae", "at least 10 rows"),
        (["0.5,10,one"] * 12, "a,b,itae", "a CSV of numbers"),
    ],
)
def test_a_table_that_is_none_is_refused_in_one_line(
    tmp_path: Path, rows: list[str], head: str, said: str
) -> None:
    with pytest.raises(StudyFileError, match=re.escape(said)) as refused:
        GivenTruth.read(table(tmp_path, rows, head), SPACE, frozenset({"itae"}))
    assert "\n" not in str(refused.value)
    with pytest.raises(StudyFileError, match="cannot be read"):
        GivenTruth.read(tmp_path / "none.csv", SPACE, frozenset({"itae"}))


def test_a_function_that_is_missing_is_refused_in_one_line(tmp_path: Path) -> None:
    study = own_plant(tmp_path, 'function = "plant.py:plnat"')
    with pytest.raises(InputError, match=r"\[is1\] function: 'plant.py' has no function 'plnat'"):
        TrueSources.open(Study.read(study))


def test_an_fmu_with_noise_is_judged_without_it(tmp_path: Path) -> None:
    quiet = write_small_study(tmp_path)
    (tmp_path / "noisy").mkdir()
    text = quiet.read_text(encoding="utf-8")
    noisy = tmp_path / "noisy" / "small.toml"
    noise = "noise = { position = 3e-4 }\n[is2]"
    noisy.write_text(text.replace("[is2]", noise, 1), encoding="utf-8")
    first, second = (
        compare(study, ["random"], seeds=1, grid=GRID, out=study.parent / "out").outcomes[0]
        for study in (quiet, noisy)
    )
    # The method does not look at what it observes, so that both ran at the same gains.
    np.testing.assert_allclose(second.best, first.best, rtol=1e-6)
