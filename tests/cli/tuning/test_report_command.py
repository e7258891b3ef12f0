"""`gmfbo report` as a person meets it."""

from __future__ import annotations

from pathlib import Path

import pytest

from gmfbo.cli import main
from gmfbo.recordings.store.pack import pack_study
from tests.reports.comparison.example_comparison import write_example_comparison
from tests.reports.study.example_studies import write_example_study
from tests.studies.small_study import write_small_study


def run(*arguments: object) -> int:
    return main([str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def example(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that holds a study, and a file that is none."""
    folder = tmp_path_factory.mktemp("example")
    write_example_study(folder)
    (folder / "text.h5").write_text("no HDF5")
    return folder


def test_folder_and_packed_study_give_the_same_page(
    example: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = example / "example.study"
    packed = pack_study(folder, tmp_path / "example.h5")
    assert run("report", folder, "--out", tmp_path / "a.html") == 0
    assert run("report", packed, "--out", tmp_path / "b.html") == 0
    assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()
    said = capsys.readouterr().out
    assert f"{folder} -> {tmp_path / 'a.html'} (0." in said


def test_a_study_that_was_tuned_has_a_page(tmp_path: Path) -> None:
    study = write_small_study(tmp_path)
    study.write_text('method = "random"\n' + study.read_text(encoding="utf-8"), encoding="utf-8")
    assert run("tune", study) == 0
    assert run("report", tmp_path / "small.study", "--out", tmp_path / "small.html") == 0
    page = (tmp_path / "small.html").read_text(encoding="utf-8")
    assert "Tuning of <b>small</b>" in page
    assert '<span class="badge none">ended</span>' in page


def test_a_comparison_has_a_page(tmp_path: Path) -> None:
    folder = write_example_comparison(tmp_path)
    assert run("report", folder, "--out", tmp_path / "c.html") == 0
    assert "Comparison <b>joint</b>" in (tmp_path / "c.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("study", "out", "said"),
    [
        ("gone.study", "x.html", "expected a study folder or a packed study, but there is none"),
        (".", "x.html", "expected a study folder, but it holds no study.toml"),
        ("example.study", "x.pdf", "expected a file name that ends in .html, got"),
        ("example.study", "no/where/x.html", "cannot write"),
        ("text.h5", "x.html", "it is no readable HDF5 file"),
    ],
)
def test_mistakes_are_one_line_and_status_2(
    example: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    study: str,
    out: str,
    said: str,
) -> None:
    assert run("report", example / study, "--out", tmp_path / out) == 2
    told = capsys.readouterr().err
    assert said in told
    assert told.count("\n") == 1
