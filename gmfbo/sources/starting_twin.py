"""A twin file to begin from, written from what an FMU says of itself."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from gmfbo.sources.fmu_variable import FmuVariable
from gmfbo.sources.role_guesses import Guess, Guesses, guess_roles

if TYPE_CHECKING:
    from gmfbo.sources.inspection import FmuReport

_STEP_S = 1e-3


def starting_twin_file(report: FmuReport) -> str:
    """Write a twin file that names every input, output and parameter; guesses are comments.

    Parameters
    ----------
    report : FmuReport
        Of `inspect_fmu`.

    Returns
    -------
    str
        TOML that loads as it is, if the FMU has an output.
    """
    guesses = guess_roles(report.inputs, report.outputs, report.parameters, report.local)
    taken: set[str] = set()
    step = report.default_step or _STEP_S
    outputs = [v for v in report.outputs if v.value_type is not None]
    blocks = [
        _head(report, step),
        _table(
            "inputs",
            "recorded signal = FMU input it drives; the rest keeps its start value",
            [
                *_signals(guesses.inputs, taken),
                *(f"# {line}" for line in _signals(guesses.idle, taken)),
            ],
        ),
        _table(
            "outputs",
            "recorded signal = FMU output it is compared with",
            [*_signals(outputs, taken), *_local_signals(guesses.outputs, taken)],
        ),
        _table(
            "parameters",
            "values over the FMU's own; remove the # to change one",
            (
                _line(v, f"# {_text(v.name)} = {v.start!r}", _bounds(v))
                for v in report.parameters
                if v.value_type is not None and v.start is not None
            ),
        ),
        *_guessed(guesses),
        _controller(report, guesses),
    ]
    return "\n".join(block for block in blocks if block)


def _guessed(guesses: Guesses) -> Iterator[str]:
    """Tables that change what gmfbo does: all of their lines are comments."""
    story = "guesses, remove the # where one is right"
    yield _table("gains", f"what tuning may move = [low, high]; {story}", _ranges(guesses.gains))
    yield _table(
        "uncertain",
        f"known only roughly = [low, high], refitted before any physics is claimed; {story}",
        _ranges(guesses.uncertain),
    )
    for name, means, entries in (
        ("ports", "FMU inputs where left-out physics may act", guesses.ports),
        ("states", "FMU outputs that physics may depend on", guesses.states),
        ("roles", "parameters with a meaning to physics", guesses.roles),
    ):
        yield _table(
            name,
            f"{means}; {story}",
            (f"# {g.key} = {_text(g.variable.name)}  # guess: {g.why}" for g in entries),
        )


def _controller(report: FmuReport, guesses: Guesses) -> str:
    """How to close a loop around a plant that has none, in comments of its own kind."""
    position = [g.variable.name for g in guesses.states if g.key == "position"]
    if guesses.drive is None or not position:
        return ""
    return "".join(
        f"## {line}\n"
        for line in (
            "It looks like a plant without a controller. One of the project's own closes the loop:",
            'in place of `fmu`, and with every name below written "plant.NAME",',
            "[fmus]",
            'controller = { kind = "pd_filtered", sample_time = 1e-3 }  # or pid, cascade_p_pi',
            f"plant = {_text(Path(report.path).name)}",
            "[wires]",
            f'{_text("plant." + guesses.drive.name)} = "controller.u"',
            f'"controller.measured" = {_text("plant." + position[0])}',
            "[inputs]",
            'reference = "controller.reference"',
        )
    )


def _head(report: FmuReport, step: float) -> str:
    stated = "" if report.default_step else ", a guess: the FMU states none"
    return (
        f"name = {_text(report.name)}\n"
        f"fmu = {_text(Path(report.path).name)}\n"
        f"step = {step!r}  # [s] communication step{stated}\n"
    )


def _table(name: str, story: str, lines: Iterable[str]) -> str:
    body = list(lines)
    # A table without entries would be refused, or say nothing; [outputs] has to be there.
    if not body and name != "outputs":
        return ""
    return f"[{name}]  # {story}\n" + "".join(f"{line}\n" for line in body)


def _signals(variables: Iterable[FmuVariable], taken: set[str]) -> Iterator[str]:
    for variable in variables:
        name = _free(_signal_name(variable.name), taken)
        taken.add(name)
        yield _line(variable, f"{name} = {_text(variable.name)}")


def _local_signals(guesses: Iterable[Guess], taken: set[str]) -> Iterator[str]:
    for guess in guesses:
        name = _free(guess.key, taken)
        taken.add(name)
        yield f"# {name} = {_text(guess.variable.name)}  # guess: {guess.why}"


def _ranges(parameters: Iterable[FmuVariable]) -> Iterator[str]:
    for variable in parameters:
        assert variable.start is not None
        low, high = sorted((0.5 * variable.start, 2.0 * variable.start))
        low = low if variable.minimum is None else max(low, variable.minimum)
        high = high if variable.maximum is None else min(high, variable.maximum)
        if low < high:
            yield _line(variable, f"# {_text(variable.name)} = [{low!r}, {high!r}]")


def _signal_name(variable: str) -> str:
    """Bare TOML key of a variable's name."""
    return re.sub(r"[^A-Za-z0-9_]+", "_", variable).strip("_") or "signal"


def _free(name: str, taken: set[str]) -> str:
    number, free = 1, name
    while free in taken:
        number += 1
        free = f"{name}_{number}"
    return free


def _line(variable: FmuVariable, entry: str, more: str = "") -> str:
    unit = f"[{variable.unit}]" if variable.unit else ""
    words = " ".join(part for part in (unit, more, variable.description) if part)
    return f"{entry}  # {' '.join(words.split())}" if words else entry


def _bounds(variable: FmuVariable) -> str:
    if variable.minimum is None and variable.maximum is None:
        return ""
    low = "-inf" if variable.minimum is None else f"{variable.minimum:g}"
    high = "inf" if variable.maximum is None else f"{variable.maximum:g}"
    return f"{low} to {high};"


def _text(value: str) -> str:
    """TOML basic string, whose escapes are those of JSON but for the control character DEL."""
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007F")
