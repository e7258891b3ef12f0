"""`gmfbo compare` as a person meets it."""

from __future__ import annotations

from pathlib import Path

import pytest

from gmfbo.cli import main
from tests.studies.small_study import write_small_study


def run(*arguments: object) -> int:
    return main([str(argument) for argument in arguments])


def test_command_prints_progress_and_tables_and_draws_again_from_the_folder(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    study, out = write_small_study(tmp_path), tmp_path / "small.compare"
    numbers = ("--seeds", 2, "--methods", "random", "--grid", 5, "--jobs", 1)
    assert run("compare", study, *numbers) == 0
    shown = capsys.readouterr().out
    assert "1 of 1: the plant, seed 0: run all over the box, once" in shown
    assert "2 of 2: random, seed 1: n* " in shown
    table = (out / "table.txt").read_text(encoding="utf-8")
    assert table in shown
    assert f"$ gmfbo compare {study.as_posix()} --seeds 2 --methods random --grid 5" in table
    assert run("compare", out) == 0
    assert capsys.readouterr().out == table


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--methods", "gmbfo"), "did you mean 'gmfbo'"),
        (("--seeds", 0), "expected at least 1, got 0"),
        (("--jobs", 0), "expected at least 1, got 0"),
    ],
)
def test_mistakes_are_one_line_and_status_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: tuple[object, ...], said: str
) -> None:
    assert run("compare", write_small_study(tmp_path), *arguments) == 2
    text = capsys.readouterr().err
    assert said in text
    assert text.count("\n") == 1


def test_folder_without_tables_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("compare", tmp_path) == 2
    assert "expected the folder of a comparison" in capsys.readouterr().err


def test_command_varies_a_key_of_the_study(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    study, out = write_small_study(tmp_path), tmp_path / "o"
    numbers = ("--seeds", 1, "--methods", "random", "--grid", 5, "--jobs", 1)
    vary = ("--vary", "budget.initial_is1 = [1, 2]")
    assert run("compare", study, *numbers, *vary, "--out", out) == 0
    shown = capsys.readouterr().out
    for number in (1, 2):
        assert f"small,budget.initial_is1={number}: random, seed 0: n*" in shown
        assert (out / f"small,budget.initial_is1={number}.compare" / "table.txt").exists()
    assert shown.count("--vary 'budget.initial_is1 = [") == 2
    for options, says in (
        ((*numbers, *vary), "give --out"),
        ((*numbers, "--vary", "seed", "--out", out), "vary: expected a key"),
    ):
        assert run("compare", study, *options) == 2
        assert says in capsys.readouterr().err
