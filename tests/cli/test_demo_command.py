"""`gmfbo demo` from tuning to the broken seal; the slow half as a person meets it."""

from __future__ import annotations

import contextlib
import functools
import hashlib
import io
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from gmfbo.cli import demo as command
from gmfbo.cli import main
from gmfbo.cli.diagnosis.diagnose import diagnose_and_show
from gmfbo.cli.hidden.draw import NOTHING, draw
from gmfbo.physics import CATALOGUE

QUIET_SEED = 25  # nothing is hidden: the shortest diagnosis
WORDS = ["demo", "--seed", str(QUIET_SEED), "--runs", "3", "--out"]
TRIED = ("coulomb_friction", "transport_delay")


@pytest.fixture(scope="module", params=["parts", pytest.param("whole", marks=pytest.mark.slow)])
def demo(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[str, Path]:
    """What it prints, and its folder."""
    folder = tmp_path_factory.mktemp("demo") / "shown"
    status, shown, said = (_whole if request.param == "whole" else _with_less_to_do)(folder)
    assert status == 0
    # No terminal is there, so each stage of the diagnosis is a line, and nothing else is.
    assert re.fullmatch(r"([a-z0-9 ]+: \d+\.\d s\n)+", said)
    return shown, folder


def _whole(folder: Path) -> tuple[int, str, str]:
    """Run it as a person does, in a process of its own."""
    done = subprocess.run(
        [sys.executable, "-m", "gmfbo", *WORDS, str(folder)],
        capture_output=True,
        text=True,
        timeout=600,
        env={**os.environ, "OMP_NUM_THREADS": "1"},
        check=False,
    )
    return done.returncode, done.stdout, done.stderr


def _with_less_to_do(folder: Path) -> tuple[int, str, str]:
    """Run it in this process, with a method that needs no twin, and two effects to try."""
    others = [name for name in CATALOGUE if name not in TRIED]
    shown, said = io.StringIO(), io.StringIO()
    with (
        pytest.MonkeyPatch.context() as patch,
        contextlib.redirect_stdout(shown),
        contextlib.redirect_stderr(said),
    ):
        patch.setattr(
            "gmfbo.cli.diagnosis.diagnose.diagnose_and_show",
            functools.partial(diagnose_and_show, exclude=others),
        )
        patch.setattr(command, "STUDY", command.STUDY.replace('"gmfbo"', '"bo_ei"', 1))
        status = main([*WORDS, str(folder)])
    return status, shown.getvalue(), said.getvalue()


def test_the_folder_holds_what_the_readme_says(demo: tuple[str, Path]) -> None:
    _, folder = demo
    assert {path.name for path in folder.iterdir()} == {
        *("demo.toml", "demo.study", "demo.h5"),
        *("sealed.json", "recordings", "found"),
    }
    found = {path.name for path in (folder / "found").iterdir()}
    assert {"diagnosis.json", "report.html", "augmented.fmu", "augmented.toml"} <= found
    assert len(list((folder / "recordings").glob("run*.csv"))) == 4


def test_the_hash_is_told_before_the_search_and_fits_the_answer(demo: tuple[str, Path]) -> None:
    shown, folder = demo
    told = re.search(r"^sha256\s+([0-9a-f]{64})$", shown, re.MULTILINE)
    assert told is not None
    assert told.start() < shown.index("simulations in") < shown.index("The seal is broken")
    answer = (folder / "sealed.json").read_bytes()
    assert told.group(1) == hashlib.sha256(answer).hexdigest()
    assert draw(QUIET_SEED).hidden == NOTHING == json.loads(answer)["hidden"]


def test_nothing_of_the_answer_is_shown_before_the_seal_is_broken(demo: tuple[str, Path]) -> None:
    shown, _ = demo
    before, after = shown.split("The seal is broken")
    assert "hidden" not in before.split("sha256")[1]
    assert re.search(r"^effect\s+nothing\s+\S", after, re.MULTILINE)


def test_it_says_whether_the_diagnosis_is_right(demo: tuple[str, Path]) -> None:
    shown, folder = demo
    verdict = json.loads((folder / "found" / "diagnosis.json").read_text())["verdict"]
    mark = "RIGHT: " if verdict == "none" else "WRONG: "
    assert shown.splitlines()[-2].startswith(mark)
