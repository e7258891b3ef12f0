"""Show a page that was written, in the browser of this machine."""

from __future__ import annotations

import webbrowser
from pathlib import Path

import typer


def show_page(page: Path) -> None:
    """Open a page in the browser; where there is none, say which file to open.

    Parameters
    ----------
    page : Path
        HTML that was written.
    """
    try:
        opened = webbrowser.open(page.resolve().as_uri())
    except webbrowser.Error:
        opened = False
    if not opened:
        typer.echo(f"! no browser opened here; open {page} yourself", err=True)
