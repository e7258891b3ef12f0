"""A study stopped at random moments proposes what an uninterrupted one proposes."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gmfbo.tuning.study.study import Study
from tests.tuning.analytic_axis import write_study
from tests.tuning.killed_study import main

ROOT = Path(__file__).resolve().parents[2]

ENDS = ("kill", "power", "ctrl-c")
BUDGET = "iterations = 4"


def start(study_file: Path) -> subprocess.Popen[str]:
    """Start the program, which prints a line after every run."""
    return subprocess.Popen(
        [sys.executable, "-m", "tests.tuning.killed_study", str(study_file)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        text=True,
    )


def seconds_between_runs(study_file: Path) -> list[float]:
    """Let the program run to its end; how long each run but the first took [s]."""
    with start(study_file) as process:
        assert process.stdout is not None
        ends = [time.perf_counter() for _ in process.stdout]
    assert process.returncode == 0
    return [float(seconds) for seconds in np.diff(ends)]


def run_until(study_file: Path, trials: int, delay: float, end: str) -> bool:
    """Start the program, stop it `delay` [s] after so many runs; True when it ended before."""
    with start(study_file) as process:
        assert process.stdout is not None
        for seen, _ in enumerate(process.stdout, start=1):
            if seen == trials:
                break
        try:
            status = process.wait(timeout=delay)
        except subprocess.TimeoutExpired:
            # SIGKILL: nothing of ours runs any more.
            process.send_signal(signal.SIGINT if end == "ctrl-c" else signal.SIGKILL)
            status = process.wait()
            # 0: it ended by itself just before.
            expected = (130, -signal.SIGINT) if end == "ctrl-c" else (-signal.SIGKILL,)
            assert status in (0, *expected), status
            return status == 0
    assert status == 0
    return True


def lose_power(study: Study, rng: np.random.Generator) -> None:
    """Leave what a power cut may leave: a line cut short, an unfinished file, no derived one."""
    log = study.location / "events.jsonl"
    line = log.read_bytes().splitlines()[-1]
    with log.open("ab") as events:
        events.write(line[: int(rng.integers(1, len(line)))])
    trial = sorted((study.location / "trials").glob("*.h5"))[-1]
    torn = trial.with_name(f".{int(trial.stem) + 1:06d}.h5.1.tmp")
    torn.write_bytes(trial.read_bytes()[: int(rng.integers(1, 2000))])
    (study.location / "index.h5").unlink(missing_ok=True)


def runs(study: Study) -> list[tuple[Any, ...]]:
    """All that a proposal could depend on."""
    return [
        (t.number, t.source, dict(t.gains), t.objective, t.parent, t.accepted) for t in study.trials
    ]


def asked(study: Study) -> dict[int, dict[str, float]]:
    """Gains that were asked for, by the number of the trial."""
    from gmfbo.recordings.store.study_folder import StudyStore

    with StudyStore.open(study.location) as store:
        return {e["number"]: e["gains"] for e in store.events() if e["event"] == "ask"}


def test_stopped_at_first_in_the_midst_and_at_last_and_resumed_equals_uninterrupted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    whole = write_study(tmp_path / "whole", method="gmfbo", seed=2, budget=BUDGET)
    begun = time.perf_counter()
    main(str(whole.origin / "axis.toml"))
    count = len(capsys.readouterr().out.splitlines())
    half_a_run = (time.perf_counter() - begun) / count / 2
    stopped = write_study(tmp_path / "stopped", method="gmfbo", seed=2, budget=BUDGET)
    # The first start ends with its first run, the second past a half, the third late.
    for trials, end in zip((1, count // 2, count // 3), ENDS, strict=True):
        assert not run_until(stopped.origin / "axis.toml", trials, half_a_run, end)
        if end == "power":
            lose_power(stopped, np.random.default_rng(4))
    main(str(stopped.origin / "axis.toml"))
    assert runs(stopped) == runs(whole)
    assert asked(stopped) == asked(whole)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["random", "bo_ei", "gmfbo"])
def test_stopped_and_resumed_equals_uninterrupted(tmp_path: Path, method: str) -> None:
    whole = write_study(tmp_path / "whole", method=method, seed=2, budget=BUDGET)
    took = seconds_between_runs(whole.origin / "axis.toml")
    stopped = write_study(tmp_path / "stopped", method=method, seed=2, budget=BUDGET)
    rng = np.random.default_rng(4)
    ends: list[str] = []
    while True:
        # Scaled by what a run takes here: however fast the machine, each end comes in the midst.
        early = len(ends) < len(ENDS)
        trials = 1 if early else int(rng.integers(1, len(took) // 3))
        delay = float(rng.uniform() * (np.median(took) if early else rng.choice(took)))
        if run_until(stopped.origin / "axis.toml", trials, delay, ENDS[len(ends) % len(ENDS)]):
            break
        ends.append(ENDS[len(ends) % len(ENDS)])
        if ends[-1] == "power":
            lose_power(stopped, rng)
        assert len(ends) < 40
    assert set(ends) == set(ENDS)
    assert runs(stopped) == runs(whole)
    assert asked(stopped) == asked(whole)
