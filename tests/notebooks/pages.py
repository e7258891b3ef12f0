"""Notebooks as pages of the documentation, with what they print and draw.

    python -m tests.notebooks.pages              # runs them all, one after the other
    python -m tests.notebooks.pages 01 03b       # these
    python -m tests.notebooks.pages --text       # writes new text around the outputs kept

A page keeps its outputs between two marks, so that a change of text alone needs no run.
"""

from __future__ import annotations

import datetime
import os
import re
import subprocess
import sys
import tempfile
import textwrap
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jupytext

ROOT = Path(__file__).resolve().parents[2]
NOTEBOOKS = ROOT / "notebooks"
PAGES = NOTEBOOKS / "docs" / "notebook_pages"
COMMAND = "python -m tests.notebooks.pages"
MOST_SECONDS_OF_A_CELL = 1800
MOST_COLUMNS = 100
_MARKS = ("<!-- output -->\n", "<!-- end of output -->\n")
_SHOWN = re.compile(
    rf"^```python\n(.*?)^```\n(?:\n{_MARKS[0]}(.*?){_MARKS[1]})?", re.MULTILINE | re.DOTALL
)
_RAN = re.compile(r"^\*(Its outputs .+)\*$", re.MULTILINE)
_COLUMNS = re.compile(r"\S {2,}\S")
"""What divides the cells of a printed table."""

_OUR_FOLDER = re.compile(r"(?:/[\w.-]+)+/gmfbo-[a-z]+-\w{8}/?")
"""A notebook's folder of temporary files; what lies there is named without it."""


@dataclass(frozen=True)
class Shown:
    """A code cell of a page, and what it printed and drew, as Markdown."""

    code: str
    output: str


def names() -> list[str]:
    """All notebooks, without their ending."""
    return [path.stem for path in sorted(NOTEBOOKS.glob("[0-9]*.py"))]


def cells(name: str) -> list[tuple[str, str]]:
    """Kind and source of each cell, links pointing from the page."""
    notebook = jupytext.read(NOTEBOOKS / f"{name}.py")
    return [(one.cell_type, one.source.strip()) for one in notebook.cells if one.source.strip()]


def kept(page: str) -> tuple[str, list[Shown]]:
    """The line that says which run a page is of, and its code cells with their outputs."""
    ran = _RAN.search(page)
    shown = [Shown(code.strip(), output or "") for code, output in _SHOWN.findall(page)]
    return (ran.group(1) if ran else ""), shown


def page(name: str, ran: str, outputs: Sequence[str]) -> str:
    """Markdown of a notebook with its outputs.

    Parameters
    ----------
    name : str
        Of the notebook, without ending.
    ran : str
        Sentence on the run that made the outputs.
    outputs : sequence of str
        Markdown, one for each code cell; empty for one that shows nothing.
    """
    following = iter(outputs)
    parts = []
    for number, (kind, source) in enumerate(cells(name)):
        if kind == "markdown":
            parts.append(re.sub(r"\]\(([^)#]+)", lambda found: "](" + _from_page(found[1]), source))
            if number == 0:
                parts.append(f"*{ran}*")
                parts.append(f"The notebook itself: [{name}.py](../../{name}.py).")
        else:
            parts.append(f"```python\n{source}\n```")
            output = next(following)
            if output:
                parts[-1] += f"\n\n{_MARKS[0]}{output}{_MARKS[1].rstrip()}"
    return "\n\n".join(parts) + "\n"


def _from_page(target: str) -> str:
    """A link of a notebook, as its page has it."""
    if "://" in target:
        return target
    if target.startswith("docs/"):
        return f"../{target.removeprefix('docs/')}"
    shown = f"{target.removesuffix('.py')}.md"
    if re.fullmatch(r"\d\w+\.py", target) and (PAGES / shown).exists():
        return shown
    return f"../../{target}"


def run(name: str, folder: Path) -> list[str]:
    """Run a notebook, write its figures, and return the outputs of its code cells.

    Parameters
    ----------
    name : str
        Of the notebook, without ending.
    folder : Path
        Of the figures; older ones of this notebook are removed.
    """
    from nbclient import NotebookClient

    notebook = jupytext.read(NOTEBOOKS / f"{name}.py")
    client = NotebookClient(
        notebook,
        timeout=MOST_SECONDS_OF_A_CELL,
        kernel_name="python3",
        resources={"metadata": {"path": str(NOTEBOOKS)}},
    )
    client.execute()
    for old in folder.glob(f"{name}-*.svg"):
        old.unlink()
    ran = [one for one in notebook.cells if one.cell_type == "code" and one.source.strip()]
    return [_output(one.outputs, folder, f"{name}-{n}") for n, one in enumerate(ran, start=1)]


def _output(outputs: Sequence[Any], folder: Path, stem: str) -> str:
    """Markdown of what a cell printed and drew."""
    printed = ""
    drawn: list[str] = []
    for one in outputs:
        data = one.get("data", {})
        if one.output_type == "stream" and one.name == "stdout":
            printed += one.text
        elif "image/svg+xml" in data:
            file = folder / f"{stem}{'abc'[len(drawn)] if drawn else ''}.svg"
            file.write_text(_plain_svg(data["image/svg+xml"]), encoding="utf-8")
            drawn.append(f"![What this cell draws]({file.name})\n")
    text = _OUR_FOLDER.sub("", printed).replace(f"{ROOT}/", "").strip("\n")
    text = "\n".join(wrapped(line.rstrip()) for line in text.splitlines())
    return (f"```text\n{text}\n```\n" if text else "") + "".join(drawn)


def wrapped(line: str) -> str:
    """A long sentence in lines that a page shows whole; rows of a table stay as they are."""
    if len(line) <= MOST_COLUMNS or _COLUMNS.search(line):
        return line
    return textwrap.fill(line, MOST_COLUMNS, break_long_words=False, break_on_hyphens=False)


def _plain_svg(text: str) -> str:
    """A drawing without the date at which it was made, and without blanks at the ends of lines."""
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    return "\n".join(line.rstrip() for line in text.splitlines() if line.strip()) + "\n"


def refresh(name: str) -> float:
    """Run a notebook and write its page; how long it ran [s].

    Parameters
    ----------
    name : str
        Of the notebook, without ending.
    """
    PAGES.mkdir(exist_ok=True)
    begun = time.monotonic()
    outputs = run(name, PAGES)
    took = time.monotonic() - begun
    commit = subprocess.run(
        ["git", "log", "-1", "--format=%h", "--", "gmfbo", "models"],
        cwd=ROOT, capture_output=True, text=True, check=True,
    ).stdout.strip()  # fmt: skip
    ran = (
        f"Its outputs are of gmfbo at commit {commit}, {datetime.date.today()}, "
        f"made by `{COMMAND} {name.partition('_')[0]}` in {took:.0f} s."
    )
    (PAGES / f"{name}.md").write_text(page(name, ran, outputs), encoding="utf-8")
    return took


def rewrite(name: str) -> str:
    """The page of a notebook with the text that it has now around the outputs that are kept.

    Parameters
    ----------
    name : str
        Of the notebook, without ending.

    Raises
    ------
    ValueError
        If a code cell is another one than that which was run.
    """
    ran, shown = kept((PAGES / f"{name}.md").read_text(encoding="utf-8"))
    code = [source for kind, source in cells(name) if kind == "code"]
    if code != [one.code for one in shown]:
        raise ValueError(f"{name}: its code has changed since it was run; {COMMAND} {name[:3]}")
    return page(name, ran, [one.output for one in shown])


def main(arguments: Sequence[str]) -> None:
    """Run the notebooks whose names begin so, or write their text alone."""
    text_alone = "--text" in arguments
    begins = tuple(f"{one}_" for one in arguments if one != "--text") or ("",)
    # Kernels and what they start find this checkout, and no colours get into their outputs.
    os.environ["PYTHONPATH"] = os.pathsep.join(
        part for part in (str(ROOT), os.environ.get("PYTHONPATH", "")) if part
    )
    with tempfile.TemporaryDirectory(prefix="notebooks-") as place:
        os.environ["TMPDIR"] = place
        for name in (one for one in names() if one.startswith(begins)):
            if not text_alone:
                print(f"{name}: {refresh(name):.0f} s", flush=True)
            elif (PAGES / f"{name}.md").exists():
                (PAGES / f"{name}.md").write_text(rewrite(name), encoding="utf-8")
            else:
                print(f"{name}: has not been run yet; {COMMAND} {name.partition('_')[0]}")


if __name__ == "__main__":
    main(sys.argv[1:])
