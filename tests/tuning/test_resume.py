"""A study killed at random moments proposes what an uninterrupted one proposes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.tuning.analytic_axis import write_study

ROOT = Path(__file__).resolve().parents[2]


def run_until(study_file: Path, trials: int, delay: float) -> bool:
    """Start the program, kill it `delay` [s] after so many runs; True when it ended before."""
    with subprocess.Popen(
        [sys.executable, "-m", "tests.tuning.killed_study", str(study_file)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        for seen, _ in enumerate(process.stdout, start=1):
            if seen == trials:
                break
        try:
            status = process.wait(timeout=delay)
        except subprocess.TimeoutExpired:
            process.kill()  # SIGKILL: nothing of ours runs any more
            return False
    assert status == 0
    return True


@pytest.mark.parametrize(
    ("method", "most_runs", "latest"), [("random", 4, 0.02), ("gmfbo", 160, 0.3)]
)
def test_killed_and_resumed_equals_uninterrupted(
    tmp_path: Path, method: str, most_runs: int, latest: float
) -> None:
    budget = "iterations = 3"
    whole = write_study(tmp_path / "whole", method=method, seed=2, budget=budget)
    assert run_until(whole.origin / "axis.toml", 10_000, 60.0)
    killed = write_study(tmp_path / "killed", method=method, seed=2, budget=budget)
    rng = np.random.default_rng(4)
    starts = 1
    while not run_until(
        killed.origin / "axis.toml",
        int(rng.integers(1, most_runs)),
        float(rng.uniform(0.0, latest)),
    ):
        starts += 1
        assert starts < 40
    assert starts > 2

    def runs(study_trials: tuple[object, ...]) -> list[tuple[object, ...]]:
        return [
            (t.number, t.source, dict(t.gains), t.objective, t.parent, t.accepted)  # type: ignore[attr-defined]
            for t in study_trials
        ]

    assert runs(killed.trials) == runs(whole.trials)
