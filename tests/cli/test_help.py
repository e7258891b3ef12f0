"""`--help` of every command is a manual page: complete, narrow, with examples that parse."""

from __future__ import annotations

import re
import shlex
from pathlib import Path
from typing import Any

import pytest
import typer
from typer.exceptions import TyperException

from gmfbo.cli import main
from gmfbo.cli.application import app
from gmfbo.cli.manual import EXITS

ROOT = Path(__file__).resolve().parents[2]
PROGRAM: Any = typer.main.get_command(app)
COMMANDS: dict[str, Any] = PROGRAM.commands


@pytest.fixture(autouse=True)
def terminal_of_80_columns(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")


def help_of(name: str, capsys: pytest.CaptureFixture[str]) -> str:
    assert main([name, "--help"] if name else ["--help"]) == 0
    return capsys.readouterr().out


def section(title: str, shown: str) -> str:
    """What stands below a heading, up to the next."""
    found = re.search(rf"^{title}:\n((?:(?: .*)?\n)+)", shown, re.MULTILINE)
    assert found is not None, f"no section '{title}'"
    return found.group(1)


def parse(line: str) -> Any:
    """Hand a command line to the parser, as far as the shell would, and run nothing."""
    program, name, *arguments = shlex.split(line.partition(" > ")[0])
    assert program == "gmfbo"
    return COMMANDS[name].make_context(
        name, arguments, parent=PROGRAM.make_context("gmfbo", [name])
    )


@pytest.mark.parametrize("name", COMMANDS)
def test_the_usage_line_has_all_that_must_be_given(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    usage = help_of(name, capsys).splitlines()[0]
    assert usage.startswith(f"Usage: gmfbo {name} ")
    for parameter in COMMANDS[name].params:
        if parameter.param_type_name == "argument":
            assert f" {parameter.metavar} " in usage
        elif parameter.required:
            assert f" {parameter.opts[0]} {parameter.metavar} " in usage


@pytest.mark.parametrize("name", COMMANDS)
def test_every_argument_and_option_is_described(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    shown = help_of(name, capsys)
    for parameter in COMMANDS[name].params:
        argument = parameter.param_type_name == "argument"
        told = section("Arguments" if argument else "Options", shown)
        term = parameter.metavar if argument else parameter.opts[0]
        assert f"\n  {term}" in f"\n{told}"
        assert len(parameter.help) > 10
        assert " ".join(parameter.help.split()) in " ".join(told.split())
        if not argument and not parameter.is_flag:
            assert parameter.metavar, f"{name} {term} does not say what its value is"


@pytest.mark.parametrize("name", COMMANDS)
def test_examples_of_a_command_parse(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    lines = [
        line.strip()
        for line in section("Examples", help_of(name, capsys)).splitlines()
        if line.startswith("    ")
    ]
    assert any(line.split()[:2] == ["gmfbo", name] for line in lines)
    for line in lines:
        with parse(line):
            pass


def test_control_an_example_with_an_unknown_option_does_not_parse() -> None:
    with pytest.raises(TyperException, match="No such option"):
        parse("gmfbo tune joint.toml --bogus")


def test_control_an_example_without_a_required_option_does_not_parse() -> None:
    with pytest.raises(TyperException, match="Missing parameter: out"):
        parse("gmfbo simulate axis.toml")


@pytest.mark.parametrize("name", ["", *COMMANDS])
def test_every_exit_status_is_told(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    told = section("Exit status", help_of(name, capsys))
    assert [int(status) for status in re.findall(r"^  (\d+) ", told, re.MULTILINE)] == [*EXITS]


@pytest.mark.parametrize("name", ["", *COMMANDS])
def test_a_help_text_fits_80_columns(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert max(map(len, help_of(name, capsys).splitlines())) < 80


def test_no_summary_in_the_list_of_commands_is_cut_off(capsys: pytest.CaptureFixture[str]) -> None:
    listed = section("Commands", help_of("", capsys))
    assert re.findall(r"^  (\S+) ", listed, re.MULTILINE) == [*COMMANDS]
    assert "..." not in listed


@pytest.mark.parametrize("name", COMMANDS)
def test_see_also_names_what_there_is(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    entries = " ".join(section("See also", help_of(name, capsys)).split()).split(", ")
    for entry in entries:
        if entry.startswith("gmfbo "):
            assert entry.removeprefix("gmfbo ") in COMMANDS
        else:
            assert (ROOT / entry).is_file()


def test_brackets_of_a_help_text_are_shown(capsys: pytest.CaptureFixture[str]) -> None:
    assert "position = [low, high]" in help_of("experiment", capsys)
    assert "[s]" in help_of("watch", capsys)


def test_compare_says_which_plants_it_takes(capsys: pytest.CaptureFixture[str]) -> None:
    told = " ".join(help_of("compare", capsys).split())
    assert "must be an FMU" not in told
    assert "for a command or a Python function a table tells it, `[compare] truth = FILE`" in told


def test_the_page_of_commands_lists_every_command_and_readme_leads_there() -> None:
    listed = (ROOT / "notebooks/docs/commands.md").read_text(encoding="utf-8")
    for name in COMMANDS:
        assert f"`gmfbo {name}" in listed
    assert "(notebooks/docs/commands.md)" in (ROOT / "README.md").read_text(encoding="utf-8")


def test_a_slip_is_sent_to_the_help_of_its_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["tune"]) == 2
    assert capsys.readouterr().err.endswith("(see 'gmfbo tune --help')\n")
