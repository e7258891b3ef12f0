"""What was said of each case of a draw: a file with a line of JSON for each."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any


def drop_cut_line(path: Path) -> None:
    """Take off a last line without an end, so that the next one begins anew."""
    content = path.read_bytes() if path.exists() else b""
    if content and not content.endswith(b"\n"):
        path.write_bytes(content[: content.rfind(b"\n") + 1])


def read_outcomes(path: Path) -> list[dict[str, Any]]:
    """Lines of a file of outcomes, the last one of each case; none where there is no file.

    Parameters
    ----------
    path : Path
        That `run` wrote. A last line that was cut short is left out; its case is run again.

    Raises
    ------
    ValueError
        A line before the last one is broken.
    """
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    outcomes: dict[str, dict[str, Any]] = {}
    for number, line in enumerate(lines, 1):
        try:
            outcome = json.loads(line)
        except json.JSONDecodeError:
            if number < len(lines):
                raise
            break
        outcomes[outcome["case"]] = outcome
    return list(outcomes.values())


def tell(text: str, file: Path | None) -> None:
    """Print a table, and write it where a file is given.

    Parameters
    ----------
    text : str
        The table.
    file : Path or None
        Its folder is made.
    """
    if file is not None:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    print(text)


def tell_of(
    about: str | None,
    arguments: Sequence[str] | None,
    table: Callable[[list[dict[str, Any]]], str],
) -> None:
    """Command line of a table: `OUTCOMES.jsonl [MORE.jsonl ...] [--text FILE]`.

    Parameters
    ----------
    about : str or None
        What it prints.
    arguments : sequence of str or None
        As typed; None for those of the process.
    table : callable
        From the lines of all files to the text.
    """
    parser = argparse.ArgumentParser(
        description=(about or "").strip(), formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("outcomes", type=Path, nargs="+")
    parser.add_argument("--text", type=Path, help="file for the table")
    given = parser.parse_args(arguments)
    tell(table([line for path in given.outcomes for line in read_outcomes(path)]), given.text)
