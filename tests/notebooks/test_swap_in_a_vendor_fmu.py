"""The notebook on a vendor's FMU runs to its end, where that FMU's package is installed."""

from __future__ import annotations

import runpy
import tempfile
from pathlib import Path

import pytest

from tests.foreign.fmus import foreign_fmu

NOTEBOOK = Path(__file__).resolve().parents[2] / "notebooks/02_swap_in_a_vendor_fmu.py"


@pytest.mark.slow
def test_a_study_goes_over_to_a_foreign_fmu_by_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    foreign_fmu("Mass_Damper")
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))  # the notebook leaves its files here
    names = runpy.run_path(str(NOTEBOOK))
    printed = capsys.readouterr().out
    assert '- twin = "own.toml"\n+ twin = "vendor.toml"\n' in printed
    assert "one line swaps the twin: " in printed
    assert '# torque = "f"  # guess: it drives the plant, unit N' in names["starting_twin"]
    assert names["results"]["vendor"].best is not None
    studies = sorted(path.name for path in tmp_path.glob("gmfbo-vendor-*/*.study"))
    assert studies == ["with_own.study", "with_vendor.study"]


def test_the_notebook_on_a_vendor_fmu_is_in_the_percent_format() -> None:
    text = NOTEBOOK.read_text(encoding="utf-8")
    assert text.startswith("# ---\n# jupyter:")
    assert text.count("\n# %%\n") >= 5
    compile(text, NOTEBOOK.name, "exec")
