"""`gmfbo diagnose` as a person meets it: arguments, screen, files, exit status."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import gmfbo.diagnosis
from gmfbo.cli import main
from gmfbo.cli.twins.many_values import repeat_flags
from gmfbo.diagnosis import Diagnosis
from gmfbo.errors import SimulationError
from gmfbo.sources.fmu_file.models import models_folder
from tests.diagnosis.example_diagnoses import friction

TWIN = models_folder() / "linear_axis.toml"


class StandIn:
    """Takes the place of the search, which has tests of its own: hands out a made result."""

    def __init__(self) -> None:
        self.call: dict[str, Any] = {}
        self.failure: BaseException | None = None

    def __call__(self, twin: Path, recordings: list[Path], **options: Any) -> Diagnosis:
        self.call = {"twin": twin, "recordings": recordings, **options}
        options["progress"]("screening", 0.5)
        if self.failure is not None:
            raise self.failure
        return friction()


@pytest.fixture
def search(monkeypatch: pytest.MonkeyPatch) -> StandIn:
    stand_in = StandIn()
    monkeypatch.setitem(vars(gmfbo.diagnosis), "diagnose", stand_in)
    return stand_in


def run(*arguments: object) -> int:
    return main([str(argument) for argument in arguments])


def complaint(capsys: pytest.CaptureFixture[str]) -> str:
    text = capsys.readouterr().err
    assert text.startswith("gmfbo: ")
    assert text.count("\n") == 1
    return text


def test_the_result_is_printed_on_one_screen_and_written(
    search: StandIn, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "new" / "axis"
    assert run("diagnose", TWIN, "a.csv", "b.csv", "--out", out) == 0
    shown, said = capsys.readouterr()
    assert shown.startswith("Coulomb friction of about 0.52 N m at the motor shaft is missing")
    assert shown.count("\n") <= 24
    assert said == ""
    assert Diagnosis.from_json(out) == friction()
    assert (out / "report.html").is_file()


def test_the_report_is_opened_only_where_that_is_asked_for(
    search: StandIn,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    opened: list[str] = []

    def shown(page: str) -> bool:
        opened.append(page)
        return True

    monkeypatch.setattr("webbrowser.open", shown)
    assert run("diagnose", TWIN, "a.csv", "--out", tmp_path) == 0
    assert opened == []
    assert run("diagnose", TWIN, "a.csv", "--out", tmp_path, "--open") == 0
    assert opened == [(tmp_path / "report.html").as_uri()]
    assert capsys.readouterr().err == ""
    search.failure = SimulationError("the FMU failed")
    assert run("diagnose", TWIN, "a.csv", "--out", tmp_path, "--open") == 3
    assert len(opened) == 1, "a diagnosis that failed has no new page to open"


@pytest.mark.skipif(sys.platform != "linux", reason="opens pages as Linux does")
@pytest.mark.parametrize(("program", "shown"), [("/bin/echo", ""), ("/no/browser", "open {page}")])
def test_a_page_is_handed_to_the_browser_of_this_machine(
    program: str, shown: str, tmp_path: Path
) -> None:
    page = tmp_path / "a page.html"
    code = f"from pathlib import Path; from gmfbo.cli.browser import show_page; \
show_page(Path({str(page)!r}))"
    finished = subprocess.run(
        [sys.executable, "-c", code],
        # No other browser is found, so that nothing opens where tests run.
        env={**os.environ, "BROWSER": f"{program} %s", "PATH": "", "DISPLAY": ""},
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    assert shown.format(page=page) in finished.stderr
    assert (page.as_uri() in finished.stdout) == (program == "/bin/echo")


def test_no_progress_is_drawn_where_output_goes_to_a_file(
    search: StandIn, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("diagnose", TWIN, "a.csv", "--out", tmp_path) == 0
    assert "screening" not in capsys.readouterr().out


def test_what_is_asked_reaches_the_search(search: StandIn, tmp_path: Path) -> None:
    options = ("--assume", "viscous_friction", "--exclude", "backlash", "--exclude", "hysteresis")
    limits = ("--seed", "3", "--jobs", "1")
    assert run("diagnose", TWIN, "a.csv", "b.csv", "--out", tmp_path, *options, *limits) == 0
    assert search.call["twin"] == TWIN
    assert search.call["recordings"] == [Path("a.csv"), Path("b.csv")]
    assert search.call["validate"] is None
    assert search.call["assume"] == ("viscous_friction",)
    assert search.call["exclude"] == ("backlash", "hysteresis")
    assert (search.call["seed"], search.call["jobs"]) == (3, 1)


@pytest.mark.parametrize(
    "arguments",
    [
        ("TWIN", "a.csv", "--validate", "v.csv", "w.csv", "--out", "OUT"),
        ("TWIN", "a.csv", "--validate", "v.csv", "--validate", "w.csv", "--out", "OUT"),
        ("--out", "OUT", "TWIN", "a.csv", "--validate", "v.csv", "w.csv"),
        ("--out", "OUT", "--validate", "v.csv", "w.csv", "--", "TWIN", "a.csv"),
        ("--out", "OUT", "--validate=v.csv", "TWIN", "a.csv", "--validate", "w.csv"),
    ],
)
def test_validate_takes_several_recordings(
    arguments: tuple[str, ...], search: StandIn, tmp_path: Path
) -> None:
    named = {"TWIN": TWIN, "OUT": tmp_path}
    assert run("diagnose", *(named.get(argument, argument) for argument in arguments)) == 0
    assert search.call["recordings"] == [Path("a.csv")]
    assert search.call["validate"] == [Path("v.csv"), Path("w.csv")]


def test_other_flags_keep_one_value() -> None:
    typed = ["t", "--out", "d", "r", "--validate", "a", "b", "--seed", "1", "c", "--validate"]
    assert repeat_flags(typed, ("--validate",)) == [
        *("t", "--out", "d", "r", "--validate", "a", "--validate", "b", "--seed", "1", "c"),
        "--validate",
    ]


def test_an_interrupted_search_writes_nothing(
    search: StandIn, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    search.failure = KeyboardInterrupt()
    assert run("diagnose", TWIN, "a.csv", "--out", tmp_path) == 130
    assert "interrupted" in complaint(capsys)
    assert list(tmp_path.iterdir()) == []


def test_a_twin_that_fails_gives_status_three(
    search: StandIn, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    search.failure = SimulationError("axis: the FMU crashed at 0.2 s; run it alone")
    assert run("diagnose", TWIN, "a.csv", "--out", tmp_path) == 3
    assert "crashed" in complaint(capsys)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("a.csv",), "--out"),
        (("--out", "x"), "REC"),
        (("a.csv", "--out", "x", "--assume", "colomb_friction"), "mean 'coulomb_friction'"),
        (("a.csv", "--out", "x", "--assume", "mass"), "is a parameter of the twin"),
        (("a.csv", "--out", "x", "--exclude", "Backlash"), "mean 'backlash'"),
        (("a.csv", "--out", "x", "--exclude", "no.such.*"), "no parameter of the twin matches"),
        (
            ("a.csv", "--out", "x", "--exclude", "backlash", "--assume", "backlash"),
            "assumed and excluded",
        ),
        (("a.csv", "--out", "file"), "expected a folder, but 'file' is a file"),
        (("a.csv", "--out", "file/below"), "a part of the path is a file"),
        (("a.csv", "--out", "x", "--jobs", "0"), "--jobs"),
    ],
)
def test_a_mistake_is_told_before_any_work(
    arguments: tuple[str, ...],
    said: str,
    search: StandIn,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("file").write_text("x")
    assert run("diagnose", TWIN, *arguments) == 2
    assert said in complaint(capsys)
    assert search.call == {}
    assert not Path("x").exists()


def test_help_names_the_command_and_its_options(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("--help") == 0
    assert "diagnose" in capsys.readouterr().out
    assert run("diagnose", "--help") == 0
    shown = capsys.readouterr().out
    for option in ("--validate", "--out", "--assume", "--exclude", "--seed", "--jobs"):
        assert option in shown
