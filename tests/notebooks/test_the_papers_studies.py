"""The notebook on the paper's studies runs small, draws what is kept, and asserts its claims."""

from __future__ import annotations

import runpy
import tempfile
from pathlib import Path

import pytest

NOTEBOOK = Path(__file__).resolve().parents[2] / "notebooks/04_the_papers_studies.py"


@pytest.mark.slow
def test_the_papers_studies_run_small(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv("GMFBO_STUDIES", raising=False)  # the whole studies take hours
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))  # the notebook leaves its files here
    names = runpy.run_path(str(NOTEBOOK))
    assert "75 % noise: the twin's objective is off by" in capsys.readouterr().out
    assert set(names["results"]) == {25, 50, 75}
    results = NOTEBOOK.parents[1] / "tests/benchmarks/results"
    there = {path.parent.name for path in results.glob("*/curves.txt")}
    assert set(names["kept"]) == there & set(names["WHOLE"]), "all whole studies are drawn"
    assert "noise_50" in there


def test_the_notebook_on_the_papers_studies_is_in_the_percent_format() -> None:
    text = NOTEBOOK.read_text(encoding="utf-8")
    assert text.startswith("# ---\n# jupyter:")
    assert text.count("\n# %%\n") >= 5
    compile(text, NOTEBOOK.name, "exec")
