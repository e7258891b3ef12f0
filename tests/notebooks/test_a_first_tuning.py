"""The first notebook runs to its end, where it asserts what it claims."""

from __future__ import annotations

import runpy
import tempfile
from pathlib import Path

import pytest

NOTEBOOK = Path(__file__).resolve().parents[2] / "notebooks/01_a_first_tuning.py"


@pytest.mark.slow
def test_five_real_runs_beat_the_gains_in_use(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))  # the notebook leaves its files here
    names = runpy.run_path(str(NOTEBOOK))
    printed = capsys.readouterr().out
    assert "better than the gains in use from real run 2 on" in printed
    assert "joint: gmfbo, 6 real runs" in printed, "the command line goes on with the study"
    assert names["best"].objective < names["start"].objective
    assert len(list(tmp_path.glob("gmfbo-first-*/joint.html"))) == 1
    for gain, (low, high) in {"ctl.Kp": (30.0, 200.0), "ctl.Kd": (2.0, 10.0)}.items():
        share = (names["best"].gains[gain] - low) / (high - low)
        assert 0.05 < share < 0.95, "the text says that the best run lies inside the range"


def test_the_first_notebook_is_in_the_percent_format() -> None:
    text = NOTEBOOK.read_text(encoding="utf-8")
    assert text.startswith("# ---\n# jupyter:")
    assert text.count("\n# %%\n") >= 5
    compile(text, NOTEBOOK.name, "exec")
