"""The notebook on the ODrive motor runs to its end, where it asserts what it claims."""

from __future__ import annotations

import os
import runpy
from pathlib import Path

import pytest

NOTEBOOK = Path(__file__).resolve().parents[2] / "notebooks/03b_odrive_cogging.py"
FOLDER = Path(os.environ.get("GMFBO_DATA", "")) / "odrive_cogging"


@pytest.mark.slow
@pytest.mark.skipif(
    "GMFBO_DATA" not in os.environ or not (FOLDER / "coggingmap_0").is_dir(),
    reason="needs analysis/cogging_torque of github gchenfc/ODrive as $GMFBO_DATA/odrive_cogging",
)
def test_the_cogging_lines_of_a_real_motor_hold_on_unseen_maps_and_runs(
    capsys: pytest.CaptureFixture[str],
) -> None:
    runpy.run_path(str(NOTEBOOK))  # no kernel is needed: it is a plain Python file
    assert "lines of the turning motor" in capsys.readouterr().out


def test_the_notebook_on_cogging_is_in_the_percent_format() -> None:
    text = NOTEBOOK.read_text(encoding="utf-8")
    assert text.startswith("# ---\n# jupyter:")
    assert text.count("\n# %%\n") >= 5
    compile(text, NOTEBOOK.name, "exec")
