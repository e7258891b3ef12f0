"""Running a draw: outcomes that are there are kept, and nothing stops the rest."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import psutil
import pytest

from tests.blind.draw.one import kept
from tests.blind.draw.outcomes import drop_cut_line, read_outcomes
from tests.blind.draw.run import run_draw
from tests.blind.draw.test_judging import answer
from tests.blind.generate import write_hashes

HERE = "tests.blind.draw.fake_engines"


def drawn(out: Path, count: int = 2) -> Path:
    """A draw of empty cases."""
    (out / "answers").mkdir(parents=True)
    for k in range(count):
        folder = out / "cases" / f"{k:03d}"
        folder.mkdir(parents=True)
        (folder / "rec0.csv").write_text("")
        content = answer(stratum="null" if k % 2 else "decoy", case=f"{k:03d}")
        (out / "answers" / f"{k:03d}.json").write_text(json.dumps(content))
    write_hashes(out)
    return out


def test_a_second_call_runs_only_what_has_no_line(tmp_path: Path) -> None:
    out, to = drawn(tmp_path / "draw"), tmp_path / "outcomes.jsonl"
    assert run_draw(out, to, engine=f"{HERE}:silent", only=["001"]) == 1
    assert run_draw(out, to, engine=f"{HERE}:silent") == 1
    assert run_draw(out, to, engine=f"{HERE}:silent") == 0
    lines = read_outcomes(to)
    assert [one["case"] for one in lines] == ["001", "000"]
    assert all(one["diagnosis"]["verdict"] == "none" for one in lines)
    assert all(one["answer"]["case"] == one["case"] for one in lines)
    assert all(one["cpu_seconds"] > 0.0 for one in lines)


def test_the_engine_gets_the_folder_of_the_case_alone(tmp_path: Path) -> None:
    out, to = drawn(tmp_path / "draw", 1), tmp_path / "outcomes.jsonl"
    run_draw(out, to, engine=f"{HERE}:silent")
    seen = read_outcomes(to)[0]["diagnosis"]["location"]["seen"]
    assert seen == [str(out / "cases" / "000")]


def test_an_engine_that_fails_leaves_its_last_words_and_can_be_tried_again(tmp_path: Path) -> None:
    out, to = drawn(tmp_path / "draw", 1), tmp_path / "outcomes.jsonl"
    run_draw(out, to, engine=f"{HERE}:breaks")
    assert read_outcomes(to)[0]["note"] == "status 1: RuntimeError: no such twin"
    assert run_draw(out, to, engine=f"{HERE}:silent") == 0
    assert run_draw(out, to, engine=f"{HERE}:silent", retry=True) == 1
    assert [one["note"] for one in read_outcomes(to)] == [""]


def test_a_case_that_takes_too_long_is_ended_and_says_so(tmp_path: Path) -> None:
    out, to = drawn(tmp_path / "draw", 1), tmp_path / "outcomes.jsonl"
    began = time.monotonic()
    run_draw(out, to, engine=f"{HERE}:sleeps", limit=1.0)
    assert time.monotonic() - began < 20.0
    assert read_outcomes(to)[0]["note"] == "more than 1 s"


@pytest.mark.skipif(os.name == "nt", reason="the test ends a process group, which Windows has not")
def test_a_runner_that_is_stopped_ends_its_case_and_writes_no_line(tmp_path: Path) -> None:
    out, to = drawn(tmp_path / "draw", 1), tmp_path / "outcomes.jsonl"
    command = [sys.executable, "-m", "tests.blind.draw.run", "--out", str(out), "--to", str(to)]
    with subprocess.Popen([*command, "--engine", f"{HERE}:sleeps"]) as runner:
        started = [psutil.Process(runner.pid)]
        while len(started) < 2 and runner.poll() is None:
            time.sleep(0.1)
            started = [*started[:1], *started[0].children(recursive=True)]
        runner.terminate()
        assert runner.wait(30.0) == 128 + signal.SIGTERM
    psutil.wait_procs(started[1:], timeout=10.0)
    assert not any(process.is_running() for process in started[1:])
    assert to.read_text() == ""


def test_strata_are_run_in_the_order_that_was_asked_for(tmp_path: Path) -> None:
    out, to = drawn(tmp_path / "draw"), tmp_path / "outcomes.jsonl"
    run_draw(out, to, engine=f"{HERE}:silent", strata=["null", "decoy"])
    assert [one["case"] for one in read_outcomes(to)] == ["001", "000"]


def test_a_line_that_was_cut_short_is_left_out_and_its_case_runs_again(tmp_path: Path) -> None:
    to = tmp_path / "outcomes.jsonl"
    to.write_text('{"case": "000"}\n{"case": "0')
    assert [one["case"] for one in read_outcomes(to)] == ["000"]
    drop_cut_line(to)
    assert to.read_text() == '{"case": "000"}\n'


def test_control_a_broken_line_amid_others_is_no_cut_one(tmp_path: Path) -> None:
    to = tmp_path / "outcomes.jsonl"
    to.write_text('{"case": "0\n{"case": "001"}\n')
    with pytest.raises(ValueError, match=r"Invalid control character|Unterminated string"):
        read_outcomes(to)


def test_an_answer_that_was_changed_is_noticed(tmp_path: Path) -> None:
    out = drawn(tmp_path / "draw", 1)
    (out / "answers" / "000.json").write_text("{}")
    with pytest.raises(ValueError, match=r"000\.json is not the answer that was hashed"):
        run_draw(out, tmp_path / "outcomes.jsonl", engine=f"{HERE}:silent")


def test_more_than_two_jobs_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="expected 1 or 2 jobs, got 3"):
        run_draw(drawn(tmp_path / "draw"), tmp_path / "outcomes.jsonl", jobs=3)


def test_a_line_keeps_what_a_recount_needs_and_no_curves() -> None:
    effect: dict[str, Any] = {"name": "backlash", "probability": 0.9, "equation": "x", "set": ["a"]}
    diagnosis = {
        "schema": 2,
        "verdict": "missing_physics",
        "effects": [effect],
        "remainder": None,
        "shape": {"port": "torque", "against": "velocity", "x": [1.0], "y": [2.0]},
        "not_testable": [],
    }
    line = kept(diagnosis)
    assert line["effects"] == [{"name": "backlash", "probability": 0.9, "set": ["a"]}]
    assert line["shape"] == {"port": "torque", "against": "velocity"}
    assert set(line) == {"schema", "verdict", "effects", "remainder", "shape"}
