"""Completion at TAB, in a real bash: the candidates, and that nobody waits for torch."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from gmfbo.physics import CATALOGUE
from gmfbo.retuning import RETUNING
from gmfbo.tuning.methods import METHODS

BASH = shutil.which("bash")
needs_bash = pytest.mark.skipif(BASH is None, reason="needs bash, whose completion it asks")

CANDIDATES = {
    "gmfbo di": ["diagnose"],
    "gmfbo tune --re": ["--resume"],
    "gmfbo tune ax": ["axis.toml"],
    "gmfbo tune ./ax": ["./axis.toml"],
    "gmfbo watch jo": ["joint.study"],
    "gmfbo report jo": ["joint.h5", "joint.study"],
    "gmfbo inspect sub/": ["sub/drive.fmu"],
    "gmfbo compare a.toml --methods gmfbo,bo": ["gmfbo,bo_ei"],
    "gmfbo compare a.toml --methods random:3,ra": [],
    "gmfbo diagnose a.toml r.csv --assume coul": ["coulomb_friction"],
    "gmfbo diagnose a.toml --validate r.csv s.csv --exclude backl": ["backlash"],
    "gmfbo columns a.toml r.csv --dialect dec": ["decimal_comma"],
    "gmfbo build --compiler z": ["zig"],
    # nothing of ours: bash completes any path by itself, as with "-o default" it does
    "gmfbo diagnose axis.toml ru": [],
    "gmfbo watch with": [],
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with files to complete, and `gmfbo` as a program."""
    for name in ("joint.study", "sub", "bin", "with blank.study"):
        (tmp_path / name).mkdir()
    for name in ("axis.toml", "run1.csv", "joint.h5", "sub/drive.fmu"):
        (tmp_path / name).touch()
    program = tmp_path / "bin" / "gmfbo"
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m gmfbo "$@"\n')
    program.chmod(0o755)
    return tmp_path


def bash(script: str, folder: Path) -> str:
    assert BASH is not None
    path = f"{folder / 'bin'}{os.pathsep}{os.environ['PATH']}"
    root = Path(__file__).resolve().parents[2]
    finished = subprocess.run(
        [BASH, "--norc", "-c", script],
        cwd=folder,
        env={**os.environ, "PATH": path, "HOME": str(folder), "PYTHONPATH": str(root)},
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    assert not finished.stderr
    return finished.stdout


@needs_bash
def test_bash_offers_what_fits(folder: Path) -> None:
    ask = "".join(
        f"COMP_WORDS=({line}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); COMPREPLY=()\n"
        '_gmfbo_completion gmfbo; printf "%s " "${COMPREPLY[@]}"; echo\n'
        for line in CANDIDATES
    )
    said = bash(f'eval "$(_GMFBO_COMPLETE=source_bash gmfbo)"\n{ask}', folder)
    assert dict(zip(CANDIDATES, map(str.split, said.splitlines()), strict=True)) == CANDIDATES


@needs_bash
def test_completion_installs_itself_for_the_shell_that_asks(folder: Path) -> None:
    said = bash("gmfbo --install-completion; complete; source .bashrc; complete -p gmfbo", folder)
    assert "bash completion installed" in said
    assert said.endswith("complete -o default -F _gmfbo_completion gmfbo\n")


@pytest.mark.parametrize(
    "words", ["gmfbo ", "gmfbo compare a.toml --methods gm", "gmfbo diagnose --assume co"]
)
def test_a_completion_loads_nothing_heavy(words: str) -> None:
    code = (
        "import atexit, sys\n"
        "heavy = ('torch', 'gpytorch', 'botorch', 'fmpy', 'h5py', 'matplotlib')\n"
        "atexit.register(lambda: print([m for m in heavy if m in sys.modules], file=sys.stderr))\n"
        "from gmfbo.cli import main\n"
        "main([])\n"
    )
    count = len(words.split(" ")) - 1
    asked = {"_GMFBO_COMPLETE": "complete_bash", "COMP_WORDS": words, "COMP_CWORD": str(count)}
    finished = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, **asked},
        capture_output=True,
        text=True,
        check=True,
    )
    assert finished.stdout.strip()
    assert finished.stderr.strip() == "[]"


def test_methods_are_offered_by_the_names_that_they_have() -> None:
    from gmfbo.cli.completion import methods

    assert methods("") == [method.name for method in METHODS.values()]
    assert {*RETUNING} < {*METHODS}


def test_effects_are_offered_by_their_names() -> None:
    from gmfbo.cli.completion import effects

    assert effects("") == [*CATALOGUE]
