"""Write a first twin file from an FMU's model description."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from gmfbo.sources.fmu_file.fmu_variable import FmuVariable, is_text_parameter
from gmfbo.sources.inspection.role_guesses import Guess, Guesses, guess_roles
from gmfbo.sources.inspection.variable_lines import (
    choices,
    described,
    range_lines,
    written_start,
)
from gmfbo.sources.twin_file.toml_lines import bare_key, free_key, toml_table, toml_text

if TYPE_CHECKING:
    from gmfbo.sources.inspection.fmu_report import FmuReport

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
        toml_table(
            "inputs",
            "recorded signal = FMU input it drives; the rest keeps its start value, or one that "
            "[parameters] gives",
            [
                *_signals(guesses.inputs, taken),
                *(f"# {line}" for line in _signals(guesses.idle, taken)),
            ],
        ),
        toml_table(
            "outputs",
            "recorded signal = FMU output it is compared with",
            [*_signals(outputs, taken), *_local_signals(guesses.outputs, taken)],
        ),
        toml_table(
            "parameters",
            "values over the FMU's own; remove the # to change one",
            (
                described(v, f"# {toml_text(v.name)} = {written_start(v)}", choices(v))
                for v in report.parameters
                if is_text_parameter(v) or (v.value_type is not None and v.start is not None)
            ),
        ),
        *_guessed(guesses),
        _controller(report, guesses),
    ]
    return "\n".join(block for block in blocks if block)


def _guessed(guesses: Guesses) -> Iterator[str]:
    """Tables by guesses, all of whose lines are comments."""
    story = "guesses, remove the # where one is right"
    yield toml_table(
        "gains",
        f"what tuning may move = [low, high]; {story}",
        _commented(range_lines(guesses.gains)),
    )
    yield toml_table(
        "uncertain",
        f"known only roughly = [low, high], refitted before any physics is claimed; {story}",
        _commented(range_lines(guesses.uncertain)),
    )
    for name, means, entries in (
        ("ports", "FMU inputs where left-out physics may act", guesses.ports),
        ("states", "FMU outputs that physics may depend on", guesses.states),
        ("roles", "parameters with a meaning to physics", guesses.roles),
    ):
        yield toml_table(
            name,
            f"{means}; {story}",
            (f"# {g.key} = {toml_text(g.variable.name)}  # guess: {g.why}" for g in entries),
        )


def _commented(lines: Iterable[str]) -> Iterator[str]:
    return (f"# {line}" for line in lines)


def _controller(report: FmuReport, guesses: Guesses) -> str:
    """Comments that show how to close a loop around a plant without a controller."""
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
            f"plant = {toml_text(Path(report.path).name)}",
            "[wires]",
            f'{toml_text("plant." + guesses.drive.name)} = "controller.u"',
            f'"controller.measured" = {toml_text("plant." + position[0])}',
            "[inputs]",
            'reference = "controller.reference"',
        )
    )


def _head(report: FmuReport, step: float) -> str:
    stated = "" if report.default_step else ", a guess: the FMU states none"
    return (
        f"name = {toml_text(report.name)}  # a skeleton; with a log of the axis, "
        "'gmfbo init FMU LOG --out DIR' writes a twin file that is checked\n"
        f"fmu = {toml_text(Path(report.path).name)}\n"
        f"step = {step!r}  # [s] communication step{stated}\n"
    )


def _signals(variables: Iterable[FmuVariable], taken: set[str]) -> Iterator[str]:
    for variable in variables:
        name = free_key(bare_key(variable.name), taken)
        yield described(variable, f"{name} = {toml_text(variable.name)}")


def _local_signals(guesses: Iterable[Guess], taken: set[str]) -> Iterator[str]:
    for guess in guesses:
        name = free_key(guess.key, taken)
        yield f"# {name} = {toml_text(guess.variable.name)}  # guess: {guess.why}"
