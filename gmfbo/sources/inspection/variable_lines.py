"""Lines of a twin file about variables of an FMU, with unit, bounds and the vendor's words."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from gmfbo.sources.fmu_file.fmu_variable import FmuVariable
from gmfbo.sources.twin_file.toml_lines import toml_text


def range_lines(parameters: Iterable[FmuVariable]) -> Iterator[str]:
    """Ranges from half to twice the start value, within the FMU's bounds, where there is room."""
    for variable in parameters:
        assert variable.start is not None
        low, high = sorted((0.5 * variable.start, 2.0 * variable.start))
        low = low if variable.minimum is None else max(low, variable.minimum)
        high = high if variable.maximum is None else min(high, variable.maximum)
        if low < high:
            yield described(variable, f"{toml_text(variable.name)} = [{low!r}, {high!r}]")


def described(variable: FmuVariable, entry: str, more: str = "") -> str:
    """An entry with a comment: unit, more words, and the vendor's description."""
    unit = f"[{variable.unit}]" if variable.unit else ""
    words = " ".join(part for part in (unit, more, variable.description) if part)
    return f"{entry}  # {' '.join(words.split())}" if words else entry


def written_start(variable: FmuVariable) -> str:
    """Start value in the words of its type."""
    if variable.type == "String":
        return toml_text(variable.start_text)
    if variable.type == "Boolean":
        return "true" if variable.start else "false"
    names = {value: name for name, value in variable.items}
    if variable.start in names:
        return toml_text(names[int(variable.start)])
    return repr(variable.start)


def choices(variable: FmuVariable) -> str:
    """Items of an enumeration, or bounds; empty where there are none."""
    if not variable.items:
        return _bounds(variable)
    return "one of " + ", ".join(f"{name}={value}" for name, value in variable.items)


def _bounds(variable: FmuVariable) -> str:
    if variable.minimum is None and variable.maximum is None:
        return ""
    low = "-inf" if variable.minimum is None else f"{variable.minimum:g}"
    high = "inf" if variable.maximum is None else f"{variable.maximum:g}"
    return f"{low} to {high};"
