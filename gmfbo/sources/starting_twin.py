"""A twin file to begin from, written from what an FMU says of itself."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from gmfbo.sources.fmu_variable import FmuVariable

if TYPE_CHECKING:
    from gmfbo.sources.inspection import FmuReport

_GAIN = re.compile(r"(^|[._\[])(k[pivda]?|gain)([._\]\d]|$)|gain", re.IGNORECASE)
_PORTS = {
    "torque": re.compile(r"force|torque|tau|load", re.IGNORECASE),
    "command": re.compile(r"command|cmd|voltage|current", re.IGNORECASE),
    "sensor": re.compile(r"sensor|enc|measure", re.IGNORECASE),
}
_REFERENCE = re.compile(r"ref|set_?point|target|desired|command|cmd", re.IGNORECASE)
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
    references, others, ports = _split_inputs(report.inputs)
    taken: set[str] = set()
    step = report.default_step or _STEP_S
    blocks = [
        _head(report, step),
        _table(
            "inputs",
            "recorded signal = FMU input it drives",
            [
                *_signals(references, taken),
                *(f"# {line}" for line in _signals(others, taken)),
            ],
        ),
        _table(
            "outputs",
            "recorded signal = FMU output it is compared with",
            _signals((v for v in report.outputs if v.value_type is not None), taken),
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
        _table(
            "gains", "guesses from the names: what tuning may move = [low, high]", _gains(report)
        ),
        _table(
            "ports",
            "guesses from the names: FMU inputs where left-out physics may act",
            (_line(v, f"# {port} = {_text(v.name)}") for port, v in ports.items()),
        ),
    ]
    return "\n".join(block for block in blocks if block)


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


def _split_inputs(
    inputs: Iterable[FmuVariable],
) -> tuple[list[FmuVariable], list[FmuVariable], dict[str, FmuVariable]]:
    """Inputs that are followed, those that nothing is known of, and those that look like ports."""
    numbers = [v for v in inputs if v.value_type is not None]
    references = [v for v in numbers if _REFERENCE.search(v.name) and not _looks_like_port(v.name)]
    if not references:
        return numbers, [], {}
    others = [v for v in numbers if v not in references]
    ports: dict[str, FmuVariable] = {}
    for variable in others:
        for port, pattern in _PORTS.items():
            if port not in ports and pattern.search(variable.name):
                ports[port] = variable
                break
    return references, [v for v in others if v not in ports.values()], ports


def _looks_like_port(name: str) -> bool:
    return re.match(r"port|dist|noise|fault", name, re.IGNORECASE) is not None


def _signals(variables: Iterable[FmuVariable], taken: set[str]) -> Iterator[str]:
    for variable in variables:
        name = _free(_signal_name(variable.name), taken)
        taken.add(name)
        yield _line(variable, f"{name} = {_text(variable.name)}")


def _gains(report: FmuReport) -> Iterator[str]:
    for variable in report.parameters:
        if variable.value_type is None or not variable.start or not _GAIN.search(variable.name):
            continue
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
