"""`gmfbo watch` beside a process that writes the study."""

from __future__ import annotations

import io
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from rich.console import Console

from gmfbo.cli import main
from gmfbo.cli.tuning import watch
from gmfbo.recordings.store.pack import pack_study
from gmfbo.reports.study.review import StudyReview
from tests.reports.study.example_studies import ExampleStudy, write_example_study


def watching(folder: Path) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "gmfbo", "watch", str(folder), "--interval", "0.1"]
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )  # fmt: skip


def first_line(process: subprocess.Popen[str]) -> str:
    assert process.stdout is not None
    return process.stdout.readline()


def test_runs_are_told_as_they_come_and_the_end_ends_it(tmp_path: Path) -> None:
    made = ExampleStudy(tmp_path / "live.study", name="live")
    with made.store:
        process = watching(tmp_path / "live.study")
        for _ in range(8):
            made.trial("IS2", made.gains())
        gains = {"ctl.Kp": 150.0, "ctl.Kd": 30.0}
        real = made.real(gains, None)
        # The watcher tells of the run while the study still goes on.
        told = first_line(process)
        assert told == f"real run 1: ctl.Kp = 150, ctl.Kd = 30, objective {real.objective:.4f}\n"
        assert process.poll() is None
        best = made.real({"ctl.Kp": 800.0, "ctl.Kd": 50.0}, None)
        made.real({"ctl.Kp": 100.0, "ctl.Kd": 50.0}, 0.5, "unsafe")
        made.end(best.gains)
        out, err = process.communicate(timeout=60)
    assert process.returncode == 0, err
    assert err == ""
    lines = out.splitlines()
    assert lines[0].startswith("real run 2: ctl.Kp = 800")
    assert lines[1].startswith("real run 3: ctl.Kp = 100")
    assert lines[1].endswith("(unsafe)")
    # 3 real runs, 8 + 3 of the twin and 6 corrected.
    assert lines[2] == "live: gmfbo_paper, 3 real runs, 17 simulated"
    assert lines[3].split(None, 1)[1] == "ctl.Kp = 800, ctl.Kd = 50"


def test_ctrl_c_ends_watching_with_status_130_and_leaves_the_study(tmp_path: Path) -> None:
    made = ExampleStudy(tmp_path / "live.study")
    with made.store:
        made.trial("IS2", made.gains())
        made.real(made.gains(), None)
        process = watching(tmp_path / "live.study")
        assert first_line(process).startswith("real run 1: ")
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
        assert process.returncode == 130
        assert (out, err) == ("", "gmfbo: interrupted; all finished work is kept\n")
        made.real(made.gains(), None)  # the writer goes on


def test_a_study_that_was_interrupted_is_told_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    made = ExampleStudy(tmp_path / "live.study")
    with made.store as store:
        made.trial("IS2", made.gains())
        store.log("interrupt", trials=1)
    screen = Console(file=io.StringIO(), width=200)
    for module in ("gmfbo.cli.tuning.watch", "gmfbo.cli.tuning.tune"):
        monkeypatch.setattr(f"{module}.console", screen)
    assert main(["watch", str(tmp_path / "live.study")]) == 0
    assert "interrupted after 1 runs" in screen.file.getvalue()  # type: ignore[attr-defined]


def test_a_terminal_of_80_columns_shows_where_the_study_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    screen = Console(file=io.StringIO(), width=80, force_terminal=True, highlight=False)
    monkeypatch.setattr(watch, "console", screen)
    review = StudyReview.read(write_example_study(tmp_path))
    assert main(["watch", str(tmp_path / "example.study")]) == 0
    shown = re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", screen.file.getvalue())  # type: ignore[attr-defined]
    assert shown.count("real run ") == 5
    assert "4 of 4 queries" in shown
    assert re.search(r"; \d+ s since the last run", shown)  # no fractions, which would flicker
    last, best = review.runs[-1].trial, review.best
    assert best is not None
    assert f"run {last.number}, corrected twin: " in shown
    assert f"ctl.Kp = 860, ctl.Kd = 50, objective {best.objective:.4f}" in shown
    assert "5 real, 19 of the twin, 10 corrected, mismatch 0.12" in shown
    assert max(map(len, shown.splitlines())) <= 80


@pytest.mark.parametrize("kind", ["none", "folder", "packed"])
def test_where_no_study_runs_one_line_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str
) -> None:
    path = tmp_path / "x.study"
    if kind == "folder":
        path.mkdir()
    elif kind == "packed":
        path = pack_study(write_example_study(tmp_path), tmp_path / "x.h5")
    assert main(["watch", str(path)]) == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert "expected" in told


def test_watching_and_reporting_load_no_torch(tmp_path: Path) -> None:
    code = (
        "import sys; from gmfbo.cli import main\n"
        f"folder = {str(write_example_study(tmp_path))!r}\n"
        "assert main(['watch', folder]) == 0\n"
        "assert main(['report', folder, '--out', folder + '.html']) == 0\n"
        "assert 'torch' not in sys.modules and 'matplotlib' not in sys.modules"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
