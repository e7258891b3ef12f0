"""The notebook that reads a store without gmfbo, run as a reader of pages does: by a kernel.

The other notebooks are run as files; of their pages it is tested that they can be made.
"""

from __future__ import annotations

import os
from pathlib import Path

import jupytext
import nbformat
import pytest
from nbclient import NotebookClient

NOTEBOOKS = Path(__file__).resolve().parents[2] / "notebooks"
NOTEBOOK = NOTEBOOKS / "06_reading_the_store.py"


@pytest.mark.slow
def test_a_correction_trained_outside_gmfbo_predicts_a_real_run_it_has_not_seen(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("TMPDIR", "IPYTHONDIR", "JUPYTER_RUNTIME_DIR"):
        monkeypatch.setenv(name, str(tmp_path))
    paths = [str(NOTEBOOKS.parent), os.environ.get("PYTHONPATH", "")]
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, paths)))
    page = jupytext.read(NOTEBOOK)
    NotebookClient(page, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = [output for cell in page.cells for output in cell.get("outputs", [])]
    printed = "".join(output.get("text", "") for output in outputs)
    assert "left-out real run: twin alone" in printed
    assert sum("image/svg+xml" in output.get("data", {}) for output in outputs) == 1, "a figure"


def test_the_reading_part_needs_nothing_of_gmfbo() -> None:
    _, reading = NOTEBOOK.read_text(encoding="utf-8").split("# ## What is in it\n")
    code = "\n".join(line for line in reading.splitlines() if not line.startswith("#"))
    assert not any(name in code for name in ("Study", "Tuner", "gmfbo.", "models_folder"))


@pytest.mark.parametrize("path", sorted(NOTEBOOKS.glob("*.py")), ids=lambda path: path.stem)
def test_every_notebook_is_a_page_and_its_text_again(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    page = jupytext.reads(text, fmt="py:percent")
    nbformat.validate(page)
    again = jupytext.reads(jupytext.writes(page, fmt="py:percent"), fmt="py:percent")
    assert [cell.source for cell in again.cells] == [cell.source for cell in page.cells]
    assert page.cells[0].cell_type == "markdown"
    assert page.cells[0].source.startswith("# ")
    assert page.cells[-1].cell_type == "code"
    assert "assert " in page.cells[-1].source, "it ends in an assertion of what it claims"
    code = "\n".join(cell.source for cell in page.cells if cell.cell_type == "code")
    assert "__file__" not in code, "a kernel has none"
