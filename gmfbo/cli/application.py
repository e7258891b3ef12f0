"""The `gmfbo` program: its commands, and how an error becomes one line and an exit status."""

from __future__ import annotations

import os
import sys
import tempfile
import traceback
from pathlib import Path
from typing import Annotated

import typer
from typer.exceptions import TyperException

from gmfbo import __version__
from gmfbo.cli import (
    ask,
    build,
    check,
    columns,
    compare,
    compensate,
    demo,
    diagnose,
    experiment,
    export,
    import_,
    inspect,
    methods,
    repair,
    report,
    simulate,
    tell,
    tune,
    watch,
)
from gmfbo.cli.many_values import ManyValuesCommand
from gmfbo.errors import GmfboError

OUR_FAULT = 1
BAD_INPUT = 2
INTERRUPTED = 130

app = typer.Typer(
    help="Tune a controller with few runs of the real axis, guided by its digital twin.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command("demo")(demo.demo)
app.command("inspect")(inspect.inspect)
app.command("import")(import_.import_)
app.command("simulate")(simulate.simulate)
app.command("tune")(tune.tune)
app.command("watch")(watch.watch)
app.command("ask")(ask.ask)
app.command("tell")(tell.tell)
app.command("check")(check.check)
app.command("columns")(columns.columns)
app.command("diagnose", cls=ManyValuesCommand)(diagnose.diagnose)
app.command("experiment")(experiment.experiment)
app.command("compensate")(compensate.compensate)
app.command("compare")(compare.compare)
app.command("methods")(methods.methods)
app.command("export")(export.export)
app.command("report")(report.report)
app.command("repair")(repair.repair)
app.command("build")(build.build)


def _show_version(asked: bool) -> None:
    if asked:
        typer.echo(f"gmfbo {__version__}")
        raise typer.Exit()


@app.callback()
def program(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_show_version, is_eager=True, help="Print the version."),
    ] = False,
) -> None:
    """Tune a controller with few runs of the real axis, guided by its digital twin."""


def main(arguments: list[str] | None = None) -> int:
    """Run the program.

    Parameters
    ----------
    arguments : list of str, optional
        Without the program's name; those of the process unless given.

    Returns
    -------
    int
        0 done, 2 bad input, 3 a simulation or plant failed, 1 a fault of ours, 130 interrupted.
    """
    try:
        outcome = app(args=arguments, prog_name="gmfbo", standalone_mode=False)
    except GmfboError as error:
        return _complain(str(error), error.exit_status)
    except (KeyboardInterrupt, typer.Abort):
        return _interrupted()
    except typer.Exit as stop:
        # Typer turns Ctrl-C into an exit of its own.
        return _interrupted() if stop.exit_code == INTERRUPTED else int(stop.exit_code)
    except TyperException as error:
        return _complain(f"{_usage(error)} (see 'gmfbo --help')", BAD_INPUT)
    except BrokenPipeError:
        # The reader of our output went away, as `head` does; nothing is left to say.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except Exception as error:
        return _complain(f"{_own_fault(error)}", OUR_FAULT)
    return _interrupted() if outcome == INTERRUPTED else int(outcome or 0)


def _interrupted() -> int:
    return _complain("interrupted; all finished work is kept", INTERRUPTED)


def _usage(error: TyperException) -> str:
    # Usage errors know how to say themselves, with the option's name in front.
    return str(getattr(error, "format_message", lambda: error)())


def _complain(message: str, status: int) -> int:
    line = " ".join(message.split())
    print(f"gmfbo: {line}", file=sys.stderr)
    return status


def _own_fault(error: Exception) -> str:
    handle, name = tempfile.mkstemp(prefix="gmfbo-fault-", suffix=".txt")
    with os.fdopen(handle, "w", encoding="utf-8") as report:
        traceback.print_exception(error, file=report)
    return (
        f"a fault of gmfbo's own ({type(error).__name__}); all finished work is kept; "
        f"please report it with {Path(name)}"
    )
