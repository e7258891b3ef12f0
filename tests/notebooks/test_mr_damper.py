"""The notebook on the damper runs to its end, where it asserts what it claims."""

from __future__ import annotations

import os
import runpy
from pathlib import Path

import pytest

NOTEBOOK = Path(__file__).resolve().parents[2] / "notebooks/03d_mr_damper.py"
FILE = Path(os.environ.get("GMFBO_DATA", "")) / "hysteresis_ce8" / "mr_damper.mat"


@pytest.mark.slow
@pytest.mark.skipif(
    "GMFBO_DATA" not in os.environ or not FILE.exists(),
    reason="needs mr_damper.mat of github RomanFoell/DRGP-VSS in hysteresis_ce8 of $GMFBO_DATA",
)
def test_hysteresis_of_a_real_damper_holds_on_unseen_samples(
    capsys: pytest.CaptureFixture[str],
) -> None:
    runpy.run_path(str(NOTEBOOK))
    assert "fit on 1499 unseen samples" in capsys.readouterr().out


def test_the_notebook_on_the_servo_is_in_the_percent_format() -> None:
    text = NOTEBOOK.read_text(encoding="utf-8")
    assert text.startswith("# ---\n# jupyter:")
    assert text.count("\n# %%\n") >= 4
    compile(text, NOTEBOOK.name, "exec")
