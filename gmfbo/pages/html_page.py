"""A self-contained page: style, script, sections and tables as HTML text, every value escaped."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from html import escape
from importlib.resources import files

_STACKED = 5  # columns of a table that do not fit side by side on a phone


@cache
def page_file(name: str, package: str = __package__) -> str:
    """Text of a style sheet or a script.

    Parameters
    ----------
    name : str
        File name.
    package : str
        Package with the file; this one holds the files that all pages share.
    """
    return files(package).joinpath(name).read_text(encoding="utf-8")


def page(title: str, body: str, styles: Sequence[str], scripts: Sequence[str]) -> str:
    """Put a body into a page of its own.

    Parameters
    ----------
    title : str
        Text of the title.
    body : str
        HTML.
    styles, scripts : sequence of str
        Texts, in order; the scripts are joined, so they see each other's names.

    Returns
    -------
    str
        The whole page; it loads nothing, and is complete without its script.
    """
    style, script = "".join(styles), "".join(scripts)
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width,initial-scale=1">'
        f"<title>{escape(title)}</title>\n<style>\n{style}</style></head>\n"
        f'<body>\n{body}\n<script>\n"use strict";\n(() => {{\n{script}}})();\n</script>'
        "</body></html>\n"
    )


def embedded_json(name: str, content: str) -> str:
    """Put JSON into the page for a script or a reader of the file.

    Returns
    -------
    str
        A `<script>` element that runs nothing; no text in it can end it.
    """
    safe = content.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e")
    return f'<script type="application/json" id="{escape(name)}">{safe}</script>'


def section(heading: str, *parts: str, name: str = "") -> str:
    """Put HTML under a heading; nothing where there is no HTML.

    Parameters
    ----------
    heading : str
        Text.
    *parts : str
        HTML; empty ones are left out.
    name : str
        Id on the page.

    Returns
    -------
    str
        A `<section>` element, or nothing.
    """
    shown = [part for part in parts if part]
    if not shown:
        return ""
    known = f' id="{escape(name)}"' if name else ""
    return f"<section{known}><h2>{escape(heading)}</h2>\n" + "\n".join(shown) + "\n</section>"


def paragraph(text: str, style: str = "") -> str:
    """Text as a paragraph; nothing for no text."""
    if not text:
        return ""
    return f'<p class="{style}">{escape(text)}</p>' if style else f"<p>{escape(text)}</p>"


def columns(*parts: str, style: str = "") -> str:
    """Put HTML side by side where the screen is wide enough; nothing for none.

    Parameters
    ----------
    *parts : str
        HTML; empty ones are left out.
    style : str
        Class in the page's style, which may set the least width of a column.
    """
    shown = "".join(f"<div>{part}</div>" for part in parts if part)
    return f'<div class="{f"columns {style}".strip()}">{shown}</div>' if shown else ""


def folded(summary: str, content: str) -> str:
    """Fold HTML behind a line of text; nothing for none."""
    if not content:
        return ""
    return f"<details><summary>{escape(summary)}</summary>{content}</details>"


def table(
    heads: Sequence[str],
    rows: Sequence[Sequence[str]],
    *,
    numbers: Sequence[int] = (),
    style: str = "",
    best: int | None = None,
) -> str:
    """Draw a table; nothing without rows.

    Parameters
    ----------
    heads : sequence of str
        Column heads, text.
    rows : sequence of sequence of str
        Cells, HTML: text has to be escaped, and numbers be marked, before.
    numbers : sequence of int
        Columns to set as numbers.
    style : str
        Class in the page's style.
    best : int, optional
        Row that stands out.

    Returns
    -------
    str
        A table whose first column heads its row. On a narrow screen one of many columns becomes a
        list for each row, where each value has the head of its column beside it.
    """
    if not rows:
        return ""
    stacks = len(heads) >= _STACKED

    def tag(kind: str, column: int) -> str:
        said = f' data-head="{escape(heads[column])}"' if stacks and kind == "td" else ""
        return f"<{kind} class=number{said}>" if column in numbers else f"<{kind}{said}>"

    head = "".join(f"{tag('th', i)}{escape(text)}</th>" for i, text in enumerate(heads))
    body = []
    for place, (first, *others) in enumerate(rows):
        cells = "".join(f"{tag('td', i)}{cell}</td>" for i, cell in enumerate(others, start=1))
        opened = '<tr class="best">' if place == best else "<tr>"
        body.append(f'{opened}<th scope="row">{first}</th>{cells}</tr>')
    styles = " ".join(filter(None, (style, "stack" if stacks else "")))
    kind = f' class="{styles}"' if styles else ""
    return (
        f'<div class="scroll"><table{kind}><thead><tr>{head}</tr></thead>'
        f"<tbody>{''.join(body)}</tbody></table></div>"
    )
