"""The notebook on one's own parts runs to its end, in a process of its own: it adds an effect."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

NOTEBOOK = Path(__file__).resolve().parents[2] / "notebooks/07_add_an_effect_a_metric_a_method.py"


@pytest.mark.slow
def test_ones_own_effect_metric_and_method_are_used_for_real(tmp_path: Path) -> None:
    environment = {name: value for name, value in os.environ.items() if name != "GMFBO_PHYSICS"}
    environment |= {"PYTHONPATH": str(NOTEBOOK.parents[1]), "TMPDIR": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-W", "error::UserWarning", str(NOTEBOOK)],
        capture_output=True,
        text=True,
        env=environment,
        cwd=tmp_path,
    )
    assert done.returncode == 0, done.stderr
    assert "found: A bellows of about 2 N m/rad3 at the motor shaft" in done.stdout
    assert "--methods turn_the_knobs,bo_ei" in done.stdout


def test_the_notebook_on_ones_own_parts_is_in_the_percent_format() -> None:
    text = NOTEBOOK.read_text(encoding="utf-8")
    assert text.startswith("# ---\n# jupyter:")
    assert text.count("\n# %%\n") >= 5
    compile(text, NOTEBOOK.name, "exec")
