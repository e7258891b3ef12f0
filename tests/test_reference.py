"""The reference builds without a warning, and holds every public name as it is."""

from __future__ import annotations

import ast
import dataclasses
import html
import importlib
import inspect
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import pytest
from numpydoc.docscrape import NumpyDocString
from sphinx.util.inventory import InventoryFile

from tests.pages.headless_browser import NO_BROWSER, Browser, browser_path

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "notebooks" / "docs"
PYTHON_BLOCK = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)


@dataclass(frozen=True)
class Built:
    """Pages that were built, and what the build said."""

    folder: Path
    status: int
    said: str

    def names(self) -> dict[str, str]:
        """What the pages hold of Python: kind by full name."""
        content = (self.folder / "objects.inv").read_bytes()
        entries = InventoryFile.loads(content, uri="").data
        return {n: kind for kind in entries if kind.startswith("py:") for n in entries[kind]}


def build(docs: Path, folder: Path) -> Built:
    """Run the command of index.md, on these sources."""
    page = (DOCS / "index.md").read_text(encoding="utf-8")
    written = re.search(r"<!-- docs command -->\n```\n(.+)\n```\n<!-- end -->", page)
    assert written is not None
    program, *arguments = shlex.split(written.group(1))
    assert program == "python"
    assert arguments[-2:] == ["notebooks/docs", "build/docs"]
    finished = subprocess.run(
        [sys.executable, *arguments[:-2], "-q", str(docs), str(folder)],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    return Built(folder, finished.returncode, finished.stdout + finished.stderr)


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Built:
    return build(DOCS, tmp_path_factory.mktemp("docs"))


def resolve(name: str) -> Any:
    """The object of a full name; where a module has the same name as a function, the function."""
    home, _, leaf = name.rpartition(".")
    try:
        holder = importlib.import_module(home)
    except ModuleNotFoundError:
        holder = resolve(home)
    return getattr(holder, leaf)


def exported_names() -> Iterator[str]:
    """Each name in an `__all__` of the package."""
    for path in sorted((ROOT / "gmfbo").rglob("*.py")):
        if "\n__all__ = " in path.read_text(encoding="utf-8"):
            parts = path.relative_to(ROOT).with_suffix("").parts
            module = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
            yield from (f"{module}.{n}" for n in importlib.import_module(module).__all__)


def shown_names() -> Iterator[str]:
    """Each name that README, a page or a notebook imports from the package."""
    pages = [ROOT / "README.md", *sorted(DOCS.glob("*.md"))]
    sources = [block for page in pages for block in PYTHON_BLOCK.findall(page.read_text("utf-8"))]
    sources += [path.read_text("utf-8") for path in sorted((ROOT / "notebooks").glob("*.py"))]
    for source in sources:
        for node in ast.walk(ast.parse(source)):
            if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "gmfbo":
                yield from (f"{node.module}.{one.name}" for one in node.names)


def test_the_pages_build_without_a_warning(built: Built) -> None:
    assert not built.said
    assert built.status == 0


def test_control_a_name_that_does_not_exist_stops_the_build(tmp_path: Path) -> None:
    shutil.copy(DOCS / "conf.py", tmp_path)
    page = "X\n=\n\n.. autofunction:: gmfbo.errors.no_such_name\n\n:py:class:`gmfbo.Nobody`\n"
    (tmp_path / "index.rst").write_text(page)
    failed = build(tmp_path, tmp_path / "built")
    assert failed.status != 0
    assert "no_such_name" in failed.said
    assert "reference target not found: gmfbo.Nobody" in failed.said


@pytest.mark.parametrize("names", [exported_names, shown_names])
def test_every_public_name_is_in_the_reference(built: Built, names: Any) -> None:
    held = built.names()
    objects = [resolve(name) for name, kind in held.items() if kind != "py:module"]
    public = set(names())
    assert len(public) > 25
    missing = {
        name
        for name in public
        if name not in held and not any(resolve(name) is one for one in objects)
    }
    assert not missing, "add them to a page in notebooks/docs/reference/"


def test_documents_import_a_main_name_from_gmfbo_itself() -> None:
    main = set(importlib.import_module("gmfbo").__all__)
    shown = set(shown_names())
    assert "gmfbo.write_recording" in shown
    deep = {name for name in shown if name.rpartition(".")[2] in main}
    assert deep <= {f"gmfbo.{name}" for name in main}


def test_every_command_is_in_the_reference(built: Built) -> None:
    from gmfbo.cli.application import app

    page = (built.folder / "reference/commands.html").read_text(encoding="utf-8")
    for command in app.registered_commands:
        assert f"Usage: gmfbo {command.name} " in page


def test_a_class_tells_each_of_its_fields_and_invents_none(built: Built) -> None:
    classes = [resolve(n) for n, kind in built.names().items() if kind == "py:class"]
    assert len(classes) > 60
    untold = {one.__name__: set(field_names(one)) - told_names(one) for one in classes}
    invented = {
        one.__name__: {n for n in told_names(one) - set(field_names(one)) if not hasattr(one, n)}
        for one in classes
    }
    assert not {name: fields for name, fields in untold.items() if fields}
    assert not {name: fields for name, fields in invented.items() if fields}


def told_names(one: type) -> set[str]:
    """Parameters and attributes in the docstrings of a class and of what it is derived from."""
    ours = [base for base in one.__mro__ if base.__module__.startswith("gmfbo.")]
    pages = [NumpyDocString(inspect.cleandoc(base.__doc__ or "")) for base in ours]
    parts = [page[part] for page in pages for part in ("Parameters", "Attributes")]
    entries = [entry.name for part in parts for entry in part]
    return {name.strip().lstrip("*") for entry in entries for name in entry.split(",")}


def field_names(one: type) -> Iterator[str]:
    """What a class is made of, or made from."""
    if dataclasses.is_dataclass(one):
        yield from (field.name for field in dataclasses.fields(one) if field.name[0] != "_")
    elif hasattr(one, "model_fields"):
        yield from one.model_fields
    elif "__init__" in vars(one) and not getattr(one, "_is_protocol", False):
        yield from [*inspect.signature(one).parameters]


def broken_links(folder: Path) -> set[str]:
    """Links between built pages that lead to no file or no anchor, and all that is fetched."""
    pages = {path: path.read_text(encoding="utf-8") for path in folder.rglob("*.html")}
    anchors = {path: set(re.findall(r'\bid="([^"]+)"', page)) for path, page in pages.items()}
    broken = set()
    for path, page in pages.items():
        fetched = re.findall(r'<(?:script|link|img)\b[^>]*?(?:src|href)="([^"]+)"', page)
        broken |= {f"{path.name}: fetches {one}" for one in fetched if "//" in one}
        for link in re.findall(r'<a\b[^>]*?href="([^"]+)"', page):
            target, _, anchor = unquote(html.unescape(link)).partition("#")
            if re.match(r"[a-z]+:", target):
                continue
            file = (path.parent / target).resolve() if target else path
            if not file.exists() or (anchor and anchor not in anchors.get(file, {anchor})):
                broken.add(f"{path.name}: {link}")
    return broken


def test_links_between_the_pages_lead_to_their_file_and_anchor(built: Built) -> None:
    assert not broken_links(built.folder)


def test_control_a_link_to_no_anchor_no_file_and_a_fetch_are_seen(tmp_path: Path) -> None:
    page = """<h1 id="here"></h1><a href="#here"></a><a class="x" href="#gone"></a>
    <a href="no.html"></a><a href="https://example.com/x"></a>
    <script src="https://example.com/a.js"></script>"""
    (tmp_path / "page.html").write_text(page, encoding="utf-8")
    assert broken_links(tmp_path) == {
        "page.html: #gone", "page.html: no.html", "page.html: fetches https://example.com/a.js"
    }  # fmt: skip


@pytest.mark.skipif(browser_path() is None, reason=NO_BROWSER)
def test_formulas_are_drawn_from_the_disk(built: Built, tmp_path: Path) -> None:
    browser = browser_path()
    assert browser is not None
    source = (built.folder / "diagnosis_decision.html").read_text(encoding="utf-8")
    formulas = len(re.findall(r'<(?:span|div) class="math notranslate', source))
    assert formulas > 5
    shown = Browser(browser, tmp_path).opened(built.folder / "diagnosis_decision.html")
    assert shown.count("<mjx-container") == formulas
    assert "Apache" in (built.folder / "_static/mathjax/LICENSE.txt").read_text(encoding="utf-8")


def test_the_pages_of_the_documentation_are_reached_from_the_first() -> None:
    first = (DOCS / "index.md").read_text(encoding="utf-8")
    for page in DOCS.glob("*.md"):
        assert page.stem == "index" or f"\n{page.stem}\n" in first
    captions = re.findall(r"^:caption: (.+)$", first, re.MULTILINE)
    concepts = first.partition(":caption: Concepts")[2].partition("```")[0].split()
    how = first.partition(":caption: How to")[2].partition("```")[0]
    for asked in (
        "notebook_pages/05_your_own_rig",
        "vendor_fmu",
        "bench",
        "many_machines",
        "own_effect",
    ):
        assert asked in how
    assert concepts[2:] == ["sources", "mismatch", "verdict", "cannot_know", "diagnosis_decision"]
    assert captions == ["Start", "How to", "Concepts", "Reference", "Benchmarks", "Decisions"]
