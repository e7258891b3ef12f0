"""README's blocks of commands, what they print, and how both are compared."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
_FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\w]|\.\d)")
LEFT_OUT = "..."
"""A line of README's that stands for any number of printed lines."""

_MARK = "== block "


@dataclass(frozen=True)
class Typed:
    """Commands that README has one type, and what it says they print."""

    commands: str
    printed: str


def typed_blocks(text: str) -> list[Typed]:
    """Blocks of commands, each with the text block that follows it before the next one."""
    found: list[Typed] = []
    for language, content in _FENCE.findall(text):
        if language == "text":
            found[-1] = Typed(found[-1].commands, content)
        else:
            found.append(Typed(content, ""))
    return found


def type_in(blocks: list[Typed], clone: Path) -> list[str]:
    """Type blocks in order into one shell, and return what each printed.

    Parameters
    ----------
    blocks : list of Typed
        Their commands stop at the first that fails.
    clone : Path
        Folder where the shell starts; it gets a `.venv` that leads to this Python.

    Returns
    -------
    list of str
        Standard output of each block.
    """
    _make_environment(clone)
    script = "set -e\n" + "".join(
        f"echo '{_MARK}{number}'\n{block.commands}" for number, block in enumerate(blocks)
    )
    done = subprocess.run(
        ["bash", "-c", script],
        cwd=clone,
        env={**os.environ, "COLUMNS": "80"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, f"{done.stdout[-2000:]}\n{done.stderr[-2000:]}"
    return re.split(rf"^{_MARK}\d+\n", done.stdout, flags=re.MULTILINE)[1:]


def _make_environment(clone: Path) -> None:
    """What `python -m venv` and pip leave behind, as far as README uses it."""
    programs = clone / ".venv" / "bin"
    programs.mkdir(parents=True)
    python = shlex.quote(sys.executable)
    (programs / "gmfbo").write_text(f'#!/bin/sh\nexec {python} -m gmfbo "$@"\n')
    (programs / "gmfbo").chmod(0o755)
    (programs / "activate").write_text(f'PATH={shlex.quote(str(programs))}:"$PATH"\n')


def difference(promised: str, printed: str) -> str:
    """First promised line that was not printed; empty where all were.

    Numbers agree within one unit of the last digit that README gives, words and signs in full,
    and blanks as far as there are any.

    Parameters
    ----------
    promised : str
        Text block of README; a line `...` stands for any number of lines.
    printed : str
        What the commands printed.

    Returns
    -------
    str
        That line, and the one that came in its place.
    """
    wanted = [line for line in promised.splitlines() if line.strip()]
    lines = [line for line in printed.splitlines() if line.strip()]
    place, skipping = 0, True
    for line in wanted:
        if line.strip() == LEFT_OUT:
            skipping = True
            continue
        hits = [k for k in range(place, len(lines)) if same_line(line, lines[k])]
        if not hits or (not skipping and hits[0] != place):
            came = lines[place] if place < len(lines) else "nothing"
            return f"README: {line}\nprinted: {came}\n\n{printed}"
        place, skipping = hits[0] + 1, False
    return ""


def same_line(promised: str, printed: str) -> bool:
    """Whether a line is what README says, within the digits that README gives."""
    if _words(promised) != _words(printed):
        return False
    pairs = zip(_NUMBER.findall(promised), _NUMBER.findall(printed), strict=True)
    return all(abs(float(a) - float(b)) <= 1.0001 * last_digit(a) for a, b in pairs)


def _words(line: str) -> list[str]:
    return _NUMBER.sub("0", line).split()


def last_digit(number: str) -> float:
    """One unit of a number's last digit: 0.01 of `6.25`, 1e4 of `3.38e6`."""
    mantissa, _, power = number.partition("e")
    decimals = len(mantissa.partition(".")[2])
    return float(10.0 ** (int(power or 0) - decimals))
