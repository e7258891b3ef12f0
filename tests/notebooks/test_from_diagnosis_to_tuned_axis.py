"""The notebook that closes the loop runs to its end, which asserts what it claims."""

from __future__ import annotations

import re
import runpy
import tempfile
from pathlib import Path

import pytest

NOTEBOOK = Path(__file__).resolve().parents[2] / "notebooks/08_from_diagnosis_to_tuned_axis.py"


@pytest.mark.slow
def test_the_corrected_twin_saves_real_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))  # the notebook leaves its files here
    names = runpy.run_path(str(NOTEBOOK))
    printed = capsys.readouterr().out
    told = re.search(r"twin version 1: A delay of about ([\d.]+) ms", printed)
    assert told is not None
    assert float(told[1]) == pytest.approx(1e3 * names["HIDDEN"]["drive.delay"], rel=0.02)
    assert names["after"] < 0.3 * names["before"]
    augmented = list(tmp_path.glob("gmfbo-tuned-*/*.study/twins/00001/augmented.fmu"))
    assert len(augmented) == 1


def test_the_notebook_that_closes_the_loop_is_in_the_percent_format() -> None:
    text = NOTEBOOK.read_text(encoding="utf-8")
    assert text.startswith("# ---\n# jupyter:")
    assert text.count("\n# %%\n") >= 5
    compile(text, NOTEBOOK.name, "exec")
