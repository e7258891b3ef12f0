"""The `gmfbo` program: its commands, and how an error becomes one line and an exit status."""

from __future__ import annotations

import os
import sys
import tempfile
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer
from typer.exceptions import TyperException

from gmfbo.cli import demo, examples
from gmfbo.cli.diagnosis import check, compensate, diagnose, effects, experiment
from gmfbo.cli.manual import EXITS, Manual, ManualCommand, ManualGroup, definitions
from gmfbo.cli.tuning import ask, compare, export, methods, repair, report, tell, tune, watch
from gmfbo.cli.twins import build, columns, import_, init, inspect, simulate
from gmfbo.cli.twins.many_values import ManyValuesCommand
from gmfbo.errors import GmfboError
from gmfbo.interrupt import unwrapped_interrupt
from gmfbo.version import __version__

OUR_FAULT = 1
BAD_INPUT = 2
INTERRUPTED = 130

_EPILOG = "\n".join(
    [
        definitions(
            "Exit status",
            {str(status): meaning for status, meaning in EXITS.items()},
        ),
        definitions(
            "Environment",
            {"GMFBO_SANDBOX": "loosens what shuts FMUs in: network, read=DIR, memory=GB, or off"},
        ),
        definitions(
            "Units",
            {
                "": "SI; angles in rad, overshoot and errors in %. An FMU's parameters and the "
                "gains have the FMU's units. The conventions are in notebooks/docs/conventions.md."
            },
        ),
        definitions("See also", {"": "'gmfbo COMMAND --help', with examples; README.md"}),
    ]
)

app = typer.Typer(
    cls=ManualGroup,
    help="Tune a controller with few runs of the real axis, guided by its digital twin.",
    epilog=_EPILOG,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # rich would take [low, high] and [s] for markup, and drop them
    context_settings={"help_option_names": ["-h", "--help"]},
)
_COMMANDS: dict[str, tuple[Callable[..., None], Manual]] = {
    "demo": (demo.demo, demo.MANUAL),
    "examples": (examples.examples, examples.MANUAL),
    "inspect": (inspect.inspect, inspect.MANUAL),
    "init": (init.init, init.MANUAL),
    "import": (import_.import_, import_.MANUAL),
    "simulate": (simulate.simulate, simulate.MANUAL),
    "tune": (tune.tune, tune.MANUAL),
    "watch": (watch.watch, watch.MANUAL),
    "ask": (ask.ask, ask.MANUAL),
    "tell": (tell.tell, tell.MANUAL),
    "check": (check.check, check.MANUAL),
    "columns": (columns.columns, columns.MANUAL),
    "diagnose": (diagnose.diagnose, diagnose.MANUAL),
    "experiment": (experiment.experiment, experiment.MANUAL),
    "effects": (effects.effects, effects.MANUAL),
    "compensate": (compensate.compensate, compensate.MANUAL),
    "compare": (compare.compare, compare.MANUAL),
    "methods": (methods.methods, methods.MANUAL),
    "export": (export.export, export.MANUAL),
    "report": (report.report, report.MANUAL),
    "repair": (repair.repair, repair.MANUAL),
    "build": (build.build, build.MANUAL),
}
_WITH_MANY_VALUES = ("diagnose",)
for _name, (_function, _manual) in _COMMANDS.items():
    _kind = ManyValuesCommand if _name in _WITH_MANY_VALUES else ManualCommand
    app.command(_name, cls=_kind, epilog=_manual.text)(_function)


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


_NO_MEMORY = (
    "this takes more memory than there is: expected shorter recordings, or fewer at a time; cut "
    "them, or give --jobs 1"
)


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
        with unwrapped_interrupt():
            outcome = app(args=arguments, prog_name="gmfbo", standalone_mode=False)
    except GmfboError as error:
        return _complain(str(error), error.exit_status)
    except (KeyboardInterrupt, typer.Abort):
        return _interrupted()
    except typer.Exit as stop:
        # Typer turns Ctrl-C into an exit of its own.
        return _interrupted() if stop.exit_code == INTERRUPTED else int(stop.exit_code)
    except TyperException as error:
        return _complain(_usage(error), BAD_INPUT)
    except BrokenPipeError:
        # The reader of our output has ended, as `head` does; no message is needed.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except MemoryError:
        return _complain(_NO_MEMORY, BAD_INPUT)
    except Exception as error:
        return _complain(f"{_own_fault(error)}", OUR_FAULT)
    return _interrupted() if outcome == INTERRUPTED else int(outcome or 0)


def _interrupted() -> int:
    return _complain("interrupted; all finished work is kept", INTERRUPTED)


def _usage(error: TyperException) -> str:
    # Usage errors format themselves, with the option's name and place.
    said = getattr(error, "format_message", lambda: error)()
    context = getattr(error, "ctx", None)
    return f"{said} (see '{context.command_path if context else 'gmfbo'} --help')"


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
