"""The notebook on one's own rig runs: a real program, real files, a person's two commands."""

from __future__ import annotations

import re
import runpy
import tempfile
from pathlib import Path

import pytest

NOTEBOOK = Path(__file__).resolve().parents[2] / "notebooks/05_your_own_rig.py"


@pytest.mark.slow
def test_every_kind_of_plant_tunes_the_same_drive(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))  # the notebook leaves its files here
    names = runpy.run_path(str(NOTEBOOK))  # no kernel is needed: it is a plain Python file
    printed = capsys.readouterr().out
    assert "four ways to run one drive, the same study: 3 real runs each" in printed
    kinds = {names[f"by_{kind}"].file.is1.model_dump_json() for kind in ("program", "recordings")}
    assert len(kinds) == 2
    studies = sorted(path.name for path in tmp_path.glob("gmfbo-rig-*/*.study"))
    assert studies == [f"{n}.study" for n in ("bench", "function", "grid", "program", "script")]
    # One of the runs fails in each of the four ways, and none of them ends its study for it.
    assert re.search(r"^ctl\.Kp = .*: failed, objective ", printed, re.MULTILINE)
    assert [names["outcomes"][0][run][1] for run in range(3)] == ["ok", "ok", "failed"]


def test_the_notebook_on_ones_own_rig_is_in_the_percent_format() -> None:
    text = NOTEBOOK.read_text(encoding="utf-8")
    assert text.startswith("# ---\n# jupyter:")
    assert text.count("\n# %%\n") >= 5
    compile(text, NOTEBOOK.name, "exec")
