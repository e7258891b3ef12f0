"""The notebook on the EMPS axis runs to its end, where it asserts what it claims."""

from __future__ import annotations

import os
import runpy
from pathlib import Path

import pytest

NOTEBOOK = Path(__file__).resolve().parents[2] / "notebooks/03_find_the_missing_physics.py"
FILE = Path(os.environ.get("GMFBO_DATA", "")) / "emps" / "DATA_EMPS.mat"


@pytest.mark.slow
@pytest.mark.skipif(
    "GMFBO_DATA" not in os.environ or not FILE.exists(),
    reason="needs DATA_EMPS.mat of nonlinearbenchmark.org in the folder emps of $GMFBO_DATA",
)
def test_the_missing_physics_of_a_real_axis_is_found(capsys: pytest.CaptureFixture[str]) -> None:
    runpy.run_path(str(NOTEBOOK))  # no kernel is needed: it is a plain Python file
    assert "force error" in capsys.readouterr().out


def test_the_notebook_is_in_the_percent_format() -> None:
    text = NOTEBOOK.read_text(encoding="utf-8")
    assert text.startswith("# ---\n# jupyter:")
    assert text.count("\n# %%\n") >= 5
    compile(text, NOTEBOOK.name, "exec")
