"""How Sphinx builds these pages; the command stands in index.md."""

from __future__ import annotations

import re
import shutil
from collections import Counter
from importlib.metadata import distribution
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.parsers.rst import Directive
from numpydoc.xref import DEFAULT_LINKS

from gmfbo.version import __version__

project = "gmfbo"
copyright = "the authors of gmfbo"
release = version = __version__

extensions = ["sphinx.ext.autodoc", "sphinx.ext.autosummary", "numpydoc", "myst_parser"]
html_theme = "furo"
html_title = f"gmfbo {release}"
html_show_sourcelink = False
html_static_path = ["style"]
pygments_dark_style = "github-dark"
html_css_files = ["narrow.css"]
man_pages = [("reference/commands", "gmfbo", "tune a controller, diagnose its twin", [], 1)]

nitpicky = True
highlight_language = "none"
default_role = "code"
myst_heading_anchors = 3
myst_enable_extensions = ["dollarmath"]

# MathJax lies beside the pages, so that formulas are drawn without a network; SVG needs no fonts.
MATHJAX = "sphinx-mathjax-offline"
mathjax_path = "mathjax/tex-svg.js"
MATHJAX_NOTE = """MathJax 3.2.2, copyright The MathJax Consortium, under the Apache License 2.0
(https://www.apache.org/licenses/LICENSE-2.0); copied from the Python package {package} {version}.
"""

# Types stand in the text of each docstring, with shapes and units, which annotations do not have.
autodoc_typehints = "none"
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True}
autosummary_generate = False  # the pages name what they hold; no stub files beside them
numpydoc_show_class_members = False  # autodoc lists them

# A function tells each of its parameters and invents none; a test holds classes to the same.
numpydoc_validation_checks = {"GL08", "PR01", "PR02", "PR03", "SS01", "RT03"}
numpydoc_validation_exclude = {r"\.[A-Z]\w*$"}

# The type of a parameter links to its class, where these pages hold one of that name.
_pages = (path.read_text() for path in Path(__file__).parent.glob("reference/*.rst"))
_named = re.findall(r"^\.\. auto(?:class|exception):: (\S+)", "".join(_pages), re.MULTILINE)
numpydoc_xref_param_type = True
_count = Counter(name.rpartition(".")[2] for name in _named)
numpydoc_xref_aliases = {
    leaf: name for name in _named if _count[leaf := name.rpartition(".")[2]] == 1
}
numpydoc_xref_ignore = "all"
DEFAULT_LINKS.clear()  # of str, ndarray and so on; they need a network

LONGEST_IN_ONE_PIECE = 24  # characters
COLUMNS_OF_A_WIDE_TABLE = 3


class CommandHelp(Directive):
    """The help text of a command, as the terminal shows it."""

    optional_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Ask the program itself."""
        from typer.testing import CliRunner

        from gmfbo.cli.application import app

        asked = CliRunner().invoke(
            app, [*self.arguments, "--help"], prog_name="gmfbo", env={"COLUMNS": "80"}
        )
        if asked.exit_code:
            raise self.error(f"gmfbo {' '.join(self.arguments)} --help: {asked.output}")
        return [nodes.literal_block(text=asked.output, language="none")]


def keep_together(app: Any, doctree: nodes.document, name: str) -> None:
    """Keep an option in one piece, a number with its per cent, and a last column of words wide."""
    for code in doctree.findall(nodes.literal):
        if len(code.astext()) <= LONGEST_IN_ONE_PIECE:
            code["classes"].append("short")
    for row in doctree.findall(nodes.row):
        if len(row) > COLUMNS_OF_A_WIDE_TABLE and len(row[-1].astext()) > LONGEST_IN_ONE_PIECE:
            row[-1]["classes"].append("words")
    for text in list(doctree.findall(nodes.Text)):
        joined = re.sub(r"(?<=\d) %", "\N{NO-BREAK SPACE}%", text)
        if joined != text and not isinstance(text.parent, nodes.literal | nodes.literal_block):
            text.parent.replace(text, nodes.Text(joined))


def copy_mathjax(app: Any, exception: Exception | None) -> None:
    """Put MathJax and a note of its licence beside the pages."""
    if exception is not None or app.builder.format != "html":
        return
    package = distribution(MATHJAX)
    source = next(file for file in package.files or () if file.match("static/mathjax/tex-svg.js"))
    folder = Path(app.outdir) / "_static" / "mathjax"
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(source.locate(), folder / "tex-svg.js")
    note = MATHJAX_NOTE.format(package=MATHJAX, version=package.version)
    (folder / "LICENSE.txt").write_text(note, encoding="utf-8")


def setup(app: Any) -> None:
    """Add the directive, and what is copied at the end of a build."""
    app.add_directive("command-help", CommandHelp)
    app.connect("doctree-resolved", keep_together)
    app.connect("build-finished", copy_mathjax)
