"""The notebook on the hobby servo runs to its end, where it asserts what it claims."""

from __future__ import annotations

import os
import runpy
from pathlib import Path

import pytest

NOTEBOOK = Path(__file__).resolve().parents[2] / "notebooks/03c_bam_servo.py"
FOLDER = Path(os.environ.get("GMFBO_DATA", "")) / "bam_xl330" / "raw"


@pytest.mark.slow
@pytest.mark.skipif(
    "GMFBO_DATA" not in os.environ or not any(FOLDER.glob("*.json")),
    reason="needs the logs of github Rhoban/bam, branch xl330, in bam_xl330/raw of $GMFBO_DATA",
)
def test_load_dependent_friction_of_a_real_servo_holds_at_unseen_gains(
    capsys: pytest.CaptureFixture[str],
) -> None:
    runpy.run_path(str(NOTEBOOK))
    assert "load_dependent_friction" in capsys.readouterr().out


def test_the_notebook_on_the_servo_is_in_the_percent_format() -> None:
    text = NOTEBOOK.read_text(encoding="utf-8")
    assert text.startswith("# ---\n# jupyter:")
    assert text.count("\n# %%\n") >= 4
    compile(text, NOTEBOOK.name, "exec")
