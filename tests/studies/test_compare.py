"""A reduced comparison on a real FMU: what it finds, keeps, and goes on from."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gmfbo import Comparison, Study, Tuner, compare
from gmfbo.errors import InputError, StoreError
from gmfbo.studies.one_run import seeded
from gmfbo.tuning.methods import find_method
from tests.studies.own_methods import Corner
from tests.studies.small_study import write_small_study

METHOD_NAMES = ["random", "bo_ei"]
GRID = 7


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Comparison:
    """Two methods, two seeds, five real runs, without a stop."""
    folder = tmp_path_factory.mktemp("whole")
    study = write_small_study(folder)
    return compare(study, METHOD_NAMES, seeds=2, grid=GRID, out=folder / "out")


def tables(text: str) -> str:
    """What does not depend on the machine."""
    return text.split("\n\n", 1)[1].split("\ntime [s]\n")[0]


def outcomes(comparison: Comparison, method: str) -> list[tuple[float, ...]]:
    """What each seed came to, by seed."""
    made = sorted(comparison.outcomes, key=lambda one: one.seed)
    return [(*one.best, *one.regret, *one.cost) for one in made if one.method == method]


def test_outcome_is_what_a_study_of_that_seed_and_method_comes_to(
    whole: Comparison, tmp_path: Path
) -> None:
    study = Study.read(write_small_study(tmp_path))
    with Tuner(
        seeded(study, 1, "random", tmp_path / "one.study"), method=find_method("random")
    ) as tuner:
        tuner.run()
        costs = [trial.objective for trial in tuner.history.of("IS1")]
    (outcome,) = [one for one in whole.outcomes if (one.method, one.seed) == ("random", 1)]
    np.testing.assert_allclose(outcome.best, np.minimum.accumulate(costs), rtol=1e-6)
    share = (np.array(outcome.best) - outcome.least) / (outcome.median - outcome.least)
    np.testing.assert_allclose(outcome.regret, share, rtol=1e-4, atol=1e-6)
    # Four twin runs and two real ones, then three real ones.
    assert outcome.cost == pytest.approx((2.4, 3.4, 4.4, 5.4))
    assert outcome.never == 6


def test_methods_share_the_truth_and_the_initial_data(whole: Comparison) -> None:
    for seed in (0, 1):
        pair = [one for one in whole.outcomes if one.seed == seed]
        assert len({(one.least, one.median, one.best[:2]) for one in pair}) == 1
    assert len({one.best for one in whole.outcomes}) > 2  # what follows is the method's own


def test_more_seeds_and_methods_grow_the_same_tables_some_with_fewer_seeds(
    tmp_path: Path,
) -> None:
    study = write_small_study(tmp_path)
    told: list[str] = []
    first = compare(study, ["random"], 1, grid=GRID, out=tmp_path / "o", progress=told.append)
    kept = (tmp_path / "o/runs/random.jsonl").read_text(encoding="utf-8")
    grown = compare(
        study,
        ["random", Corner(), "bo_ei:1"],
        2,
        grid=GRID,
        out=tmp_path / "o",
        progress=told.append,
    )
    assert len(first.outcomes) == 1
    made = [(one.method, one.seed) for one in grown.outcomes]
    assert sorted(made) == [
        ("bo_ei", 0),
        ("corner", 0),
        ("corner", 1),
        ("random", 0),
        ("random", 1),
    ]
    lines = (tmp_path / "o/runs/random.jsonl").read_text(encoding="utf-8").splitlines()
    assert (lines[0] + "\n", len(lines)) == (kept, 2)
    assert sum(line.startswith("1 of 4: corner") for line in told) == 1
    assert "random,corner,bo_ei:1" in grown.text
    assert grown.text.count("$ gmfbo compare") == 2


def test_interrupted_comparison_goes_on_to_the_same_tables(
    whole: Comparison, tmp_path: Path
) -> None:
    study, told = write_small_study(tmp_path), list[str]()

    def interrupt(line: str) -> None:
        told.append(line)
        if len(told) == 3:  # the plant over the box, and two runs
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        compare(study, METHOD_NAMES, 2, grid=GRID, out=tmp_path / "o", progress=interrupt)
    finished = {path: path.read_bytes() for path in (tmp_path / "o").glob("runs/*.jsonl")}
    assert sum(content.count(b"\n") for content in finished.values()) == 2
    resumed = compare(study, METHOD_NAMES, 2, grid=GRID, out=tmp_path / "o")
    assert tables(resumed.text) == tables(whole.text)
    for path, content in finished.items():
        assert path.read_bytes().startswith(content)


@pytest.mark.slow
def test_killed_comparison_goes_on_to_the_same_tables(whole: Comparison, tmp_path: Path) -> None:
    study, out = write_small_study(tmp_path), tmp_path / "out"
    command = [
        sys.executable,
        "-m",
        "gmfbo",
        "compare",
        str(study),
        "--seeds",
        "2",
        "--methods",
        ",".join(METHOD_NAMES),
        "--grid",
        str(GRID),
        "--out",
        str(out),
        "--jobs",
        "1",
    ]
    root = Path(__file__).resolve().parents[2]
    with subprocess.Popen(
        command, env={**os.environ, "PYTHONPATH": str(root)}, stdout=subprocess.DEVNULL
    ) as process:
        limit = time.monotonic() + 60.0
        # Killed in the midst of a run, with at least one finished.
        while not list(out.glob("runs/*.jsonl")):
            assert process.poll() is None, "it ended before it could be killed"
            assert time.monotonic() < limit
            time.sleep(0.01)
        process.kill()
    finished = {path.name: path.read_bytes() for path in out.glob("runs/*.jsonl")}
    assert 1 <= sum(content.count(b"\n") for content in finished.values()) < 4
    resumed = compare(study, METHOD_NAMES, 2, grid=GRID, out=out)
    assert tables(resumed.text) == tables(whole.text)
    for name, content in finished.items():
        assert (out / "runs" / name).read_bytes().startswith(content)


@pytest.mark.slow
def test_runs_on_two_processes_come_to_the_same_tables(whole: Comparison, tmp_path: Path) -> None:
    study = write_small_study(tmp_path)
    result = compare(study, METHOD_NAMES, 2, grid=GRID, out=tmp_path / "o", jobs=2)
    assert tables(result.text) == tables(whole.text)


def test_runs_on_an_executor_of_ones_own_come_to_the_same(
    whole: Comparison, tmp_path: Path
) -> None:
    study = write_small_study(tmp_path)
    with ThreadPoolExecutor(1) as pool:
        result = compare(study, ["random"], 2, grid=GRID, out=tmp_path / "o", jobs=pool)
    assert outcomes(result, "random") == outcomes(whole, "random")


@pytest.mark.parametrize(
    ("method", "jobs", "reason"),
    [
        (Corner(breaks=True), 1, "the corner is used up"),
        pytest.param(Corner(dies=True), 2, "from outside", marks=pytest.mark.slow),
    ],
)
def test_run_that_breaks_is_named_and_tried_again_and_costs_no_other(
    whole: Comparison, tmp_path: Path, method: Corner, jobs: int, reason: str
) -> None:
    study = write_small_study(tmp_path)
    result = compare(study, [method, "random"], 1, grid=GRID, out=tmp_path / "o", jobs=jobs)
    assert [one.method for one in result.outcomes] == ["random"]
    assert outcomes(result, "random") == outcomes(whole, "random")[:1]
    assert reason in result.failed["corner-0"]
    assert "no result: corner-0" in result.text
    again = compare(study, [Corner(), "random"], 1, grid=GRID, out=tmp_path / "o")
    assert sorted(one.method for one in again.outcomes) == ["corner", "random"]
    assert not again.failed
    assert "no result" not in again.text


def test_goal_is_that_of_the_changed_plant(tmp_path: Path) -> None:
    change = 'change = { after_runs = 3, parameters = { "viscous_friction" = 900.0 } }'
    study = write_small_study(tmp_path, change=change)
    (one,) = compare(study, [Corner()], 1, grid=GRID, out=tmp_path / "o").outcomes
    assert len(list((tmp_path / "o/truth").glob("*.csv"))) == 3  # plant, changed plant, twin
    # The same corner again and again: its cost changes once, with the plant.
    assert one.best[2] <= one.best[0]
    assert one.best[3] == one.best[4] != one.best[2]


@pytest.mark.parametrize(
    ("change", "noticed"),
    [
        ('change = { after_runs = 6, parameters = { "viscous_friction" = 900.0 } }', True),
        ("", False),
    ],
    ids=["changed", "unchanged"],
)
def test_changes_of_the_plant_that_were_noticed_are_kept(
    tmp_path: Path, change: str, noticed: bool
) -> None:
    path = write_small_study(tmp_path, change=change)
    path.write_text(path.read_text(encoding="utf-8").replace("is1_runs = 5", "is1_runs = 12"))
    (one,) = compare(path, [Corner()], 1, grid=GRID, out=tmp_path / "o").outcomes
    assert one.alarms is not None
    assert (len(one.alarms) == 1) is noticed
    assert all(8 <= run <= 12 for run in one.alarms)


def test_budget_of_the_publication_holds_where_the_file_has_none(tmp_path: Path) -> None:
    path = write_small_study(tmp_path)
    path.write_text(path.read_text(encoding="utf-8").replace("is1_runs = 5\n", ""))
    study = seeded(Study.read(path), 3, "random", tmp_path / "x")
    assert study.file.budget.is1_runs == 22
    assert study.file.budget.most_queries >= 100
    assert (study.file.seed, study.file.method) == (3, "random")


def test_runs_of_another_study_are_not_mixed_in(tmp_path: Path) -> None:
    out = tmp_path / "o"
    compare(write_small_study(tmp_path), [Corner()], 1, grid=GRID, out=out)
    with pytest.raises(StoreError, match="another study file, twin or grid"):
        compare(write_small_study(tmp_path, mass=140.0), [Corner()], 1, grid=GRID, out=out)
    with pytest.raises(StoreError, match="another study file, twin or grid"):
        compare(write_small_study(tmp_path), [Corner()], 1, grid=GRID + 1, out=out)


@pytest.mark.parametrize(
    ("methods", "numbers", "match"),
    [
        (["bo_ie"], {}, "did you mean 'bo_ei'"),
        (["random:none"], {}, "expected NAME:SEEDS"),
        (["random", "random:3"], {}, "expected each once"),
        (["random"], {"seeds": 0}, "seeds: expected at least 1, got 0"),
        (["random"], {"jobs": 0}, "jobs: expected at least 1, got 0"),
        (["random"], {"first_seed": -1}, "first-seed: expected at least 0"),
        (["random"], {"grid": 1}, "grid: expected at least 3"),
    ],
)
def test_what_makes_no_sense_is_refused_before_anything_runs(
    tmp_path: Path, methods: list[str], numbers: dict[str, Any], match: str
) -> None:
    with pytest.raises(InputError, match=match):
        compare(write_small_study(tmp_path), methods, out=tmp_path / "o", **numbers)
    assert not (tmp_path / "o").exists()


def test_kept_runs_are_small_texts_anyone_can_read(whole: Comparison) -> None:
    paths = sorted((whole.folder / "runs").iterdir())
    assert [path.name for path in paths] == ["bo_ei.jsonl", "random.jsonl"]
    for path in paths:
        lines = path.read_text(encoding="utf-8").splitlines()
        assert [json.loads(line)["seed"] for line in lines] == [0, 1]
        assert {json.loads(line)["method"] for line in lines} == {path.stem}
        assert path.stat().st_size < 4000


@pytest.fixture
def copied(whole: Comparison, tmp_path: Path) -> Comparison:
    """The tables alone, elsewhere."""
    pytest.importorskip("matplotlib")
    folder = tmp_path / "tables"
    folder.mkdir()
    for name in ("table.txt", "curves.txt", "landscape.txt"):
        (folder / name).write_bytes((whole.folder / name).read_bytes())
    return Comparison.read(folder)


def test_figures_follow_from_the_tables_alone(copied: Comparison, tmp_path: Path) -> None:
    drawn = copied.draw(tmp_path / "b")
    assert sorted(path.name for path in drawn) == [
        "best_observed.svg",
        "landscape.svg",
        "sampling_cost.svg",
    ]


@pytest.mark.slow
def test_figures_of_the_tables_alone_are_the_same_bytes(
    whole: Comparison, copied: Comparison, tmp_path: Path
) -> None:
    first, again = whole.draw(tmp_path / "a"), copied.draw(tmp_path / "b")
    for one, other in zip(first, again, strict=True):
        assert one.read_bytes() == other.read_bytes()
