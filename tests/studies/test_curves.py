"""Curves: means over seeds, and the text they are kept as."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gmfbo.errors import StoreError
from gmfbo.reports.comparison.curves import Landscape
from gmfbo.studies.curves import curves_of, curves_text, read_curves
from gmfbo.studies.landscape import landscape_text, read_landscape
from gmfbo.studies.outcome import Outcome, read_outcomes, write_outcomes
from tests.studies.small_study import outcome

PAIR = [
    outcome("random", 0, regret=(1.0, 0.5, 0.1), seconds=(0.1, 0.1)),
    outcome("random", 1, regret=(0.6, 0.1), seconds=(0.1,)),
]


def test_curve_is_the_mean_as_far_as_all_seeds_go() -> None:
    objective, regret, cost = curves_of({"random": PAIR})
    np.testing.assert_array_equal(regret.x, [1.0, 2.0])
    np.testing.assert_allclose(regret.mean, [0.8, 0.3])
    np.testing.assert_array_equal(cost.x, [0.0, 1.0])
    np.testing.assert_allclose(cost.mean, [1.4, 2.4])
    np.testing.assert_allclose(objective.mean, -2.0 + 2.0 * regret.mean)
    assert np.all((regret.low <= regret.mean) & (regret.mean <= regret.high))
    assert regret.seeds == 2


def test_curves_come_back_from_their_text(tmp_path: Path) -> None:
    made = curves_of({"random": PAIR, "bo_ei": PAIR[:1]})
    path = tmp_path / "curves.txt"
    path.write_text(curves_text(made), encoding="utf-8")
    again = read_curves(path)
    assert [(c.method, c.name, c.seeds) for c in again] == [
        (c.method, c.name, c.seeds) for c in made
    ]
    for one, other in zip(made, again, strict=True):
        for field in ("x", "mean", "low", "high"):
            np.testing.assert_allclose(getattr(other, field), getattr(one, field), rtol=1e-5)


@pytest.mark.parametrize("content", ["", "something else\n", None])
def test_what_is_no_table_of_curves_is_refused(tmp_path: Path, content: str | None) -> None:
    path = tmp_path / "curves.txt"
    if content is not None:
        path.write_text(content, encoding="utf-8")
    with pytest.raises(StoreError, match="expected the curves of a comparison"):
        read_curves(path)


def test_landscape_comes_back_from_its_text(tmp_path: Path) -> None:
    x, y = np.linspace(30.0, 200.0, 4), np.linspace(2.0, 10.0, 3)
    costs = np.subtract.outer(x / 100.0, y)
    made = Landscape(("ctl.Kp", "ctl.Kd"), x, y, costs, np.abs(costs), seed=7)
    path = tmp_path / "landscape.txt"
    path.write_text(landscape_text(made), encoding="utf-8")
    again = read_landscape(path)
    assert again is not None
    assert (again.names, again.seed) == (made.names, made.seed)
    for field in ("x", "y", "objective", "error"):
        np.testing.assert_allclose(getattr(again, field), getattr(made, field), rtol=1e-3)


def test_outcomes_come_back_from_their_text_by_seed(tmp_path: Path) -> None:
    made = [outcome("bo_ei", seed, 4, regret=(0.7, 0.01), alarms=(6,)) for seed in (3, 1)]
    write_outcomes(tmp_path / "bo_ei.jsonl", made)
    assert read_outcomes(tmp_path / "bo_ei.jsonl") == made[::-1]


def test_run_of_a_version_that_kept_no_alarms_is_read() -> None:
    early = outcome("bo_ei", 1, 4)
    line = early.line.replace(', "alarms": null', "")
    assert "alarms" not in line
    assert Outcome.of_line(line) == early


@pytest.mark.parametrize("content", ["", "{}", "[1]", '{"method": "random"}', "\xff"])
def test_broken_text_of_a_run_is_named(tmp_path: Path, content: str) -> None:
    path = tmp_path / "random.jsonl"
    path.write_text(outcome("random", 0, 4).line + "\n" + content + "\n", encoding="utf-8")
    with pytest.raises(StoreError, match=r"random\.jsonl: expected .* finished run in line 2"):
        read_outcomes(path)


def test_file_of_runs_that_is_no_text_is_named(tmp_path: Path) -> None:
    path = tmp_path / "random.jsonl"
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(StoreError, match=r"random\.jsonl: cannot be read"):
        read_outcomes(path)
