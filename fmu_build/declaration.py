"""A model as `model.toml` declares it: the one place where its variables are listed."""

from __future__ import annotations

import itertools
import math
import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from fmu_build.failure import BuildError
from fmu_build.units import parse_unit

Causality = Literal["parameter", "input", "output", "local"]
VariableType = Literal["Real", "Integer", "Boolean"]

_FIELDS = ("name", "causality", "type", "unit", "start", "min", "max", "description")
_VARIABLE_KEYS = frozenset({*_FIELDS, "tunable", "dimensions"})
_TIMES = ("internal_step", "communication_step", "stop_time")
_MODEL_KEYS = frozenset(
    {*_TIMES, "name", "description", "sources", "kind", "platforms", "test_only", "fmi", "variable"}
)


@dataclass(frozen=True)
class Variable:
    """One scalar FMI variable; its index in the list is its value reference."""

    name: str
    causality: Causality
    type: VariableType
    unit: str
    start: float
    low: float
    high: float
    description: str
    tunable: bool

    @property
    def has_start(self) -> bool:
        """Whether the user may give a value; outputs and locals are computed."""
        return self.causality in ("parameter", "input")


@dataclass(frozen=True)
class Declaration:
    """A model's variables and times.

    Attributes
    ----------
    folder : Path
        Where model.toml lies.
    internal_step, communication_step, stop_time : float
        [s] Inner step of the integrator; step and length of the default experiment.
    sources : tuple of str
        C files of the model, and headers from elsewhere, relative to `folder`.
    kind : {"co_simulation", "model_exchange"}
        What the FMU says it is.
    platforms : tuple of str or None
        The only platforms to build for; None for all.
    test_only : bool
        Whether it serves the tests and does not ship.
    fmi : tuple of int
        Major versions of FMI that it is built for.
    arrays : mapping of str to tuple of int
        First index and number of elements of each declared name; scalars have one.
    """

    folder: Path
    name: str
    description: str
    internal_step: float
    communication_step: float
    stop_time: float
    sources: tuple[str, ...]
    kind: Literal["co_simulation", "model_exchange"]
    platforms: tuple[str, ...] | None
    test_only: bool
    fmi: tuple[int, ...]
    variables: tuple[Variable, ...]
    arrays: dict[str, tuple[int, int]]


def read_declaration(path: Path) -> Declaration:
    """Read and check a model.toml.

    Raises
    ------
    BuildError
        With file and variable, for anything that does not fit.
    """
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, tomllib.TOMLDecodeError) as error:
        raise BuildError(f"{path}: cannot be read: {error}") from None
    _refuse_unknown(table, _MODEL_KEYS, str(path))
    variables: list[Variable] = []
    arrays: dict[str, tuple[int, int]] = {}
    for entry in table.get("variable", []):
        elements = list(_expand(entry, path))
        arrays[entry["name"]] = (len(variables), len(elements))
        variables.extend(elements)
    _refuse_duplicates(variables, arrays, path)
    try:
        internal_step = float(table["internal_step"])
        declaration = Declaration(
            folder=path.parent,
            name=table["name"],
            description=table["description"],
            internal_step=internal_step,
            communication_step=float(table.get("communication_step", internal_step)),
            stop_time=float(table.get("stop_time", 1.0)),
            sources=tuple(table.get("sources", [f"{table['name']}.c"])),
            kind=table.get("kind", "co_simulation"),
            platforms=tuple(table["platforms"]) if "platforms" in table else None,
            test_only=table.get("test_only", False),
            fmi=_versions(table.get("fmi", [2]), path),
            variables=tuple(variables),
            arrays=arrays,
        )
    except KeyError as error:
        raise BuildError(f"{path}: the key {error} is missing") from None
    return declaration


def _versions(given: list[int], path: Path) -> tuple[int, ...]:
    if not given or not set(given) <= {2, 3}:
        raise BuildError(f"{path}: fmi: expected [2], [3] or [2, 3], got {given}")
    return tuple(given)


def _expand(entry: dict[str, Any], path: Path) -> Iterator[Variable]:
    """One variable for each element, row by row, named name[i,j] from 1."""
    where = f"{path}: variable '{entry.get('name', '?')}'"
    _refuse_unknown(entry, _VARIABLE_KEYS, where)
    dimensions = entry.get("dimensions", [])
    indices = list(itertools.product(*(range(1, n + 1) for n in dimensions)))
    starts = _flatten(entry.get("start", 0.0), dimensions, where)
    for index, start in zip(indices, starts, strict=True):
        suffix = f"[{','.join(map(str, index))}]" if index else ""
        yield _scalar(entry, suffix, start, where)


def _flatten(start: Any, dimensions: list[int], where: str) -> list[float]:
    if not isinstance(start, list):
        return [float(start)] * math.prod(dimensions)
    if not dimensions or len(start) != dimensions[0]:
        raise BuildError(f"{where}: start has {len(start)} rows, dimensions are {dimensions}")
    return [value for row in start for value in _flatten(row, dimensions[1:], where)]


def _scalar(entry: dict[str, Any], suffix: str, start: float, where: str) -> Variable:
    causality = entry.get("causality")
    if causality not in ("parameter", "input", "output", "local"):
        raise BuildError(
            f"{where}: causality must be parameter, input, output or local, not {causality}"
        )
    kind = entry.get("type", "Real")
    if kind not in ("Real", "Integer", "Boolean"):
        raise BuildError(f"{where}: type must be Real, Integer or Boolean, not {kind}")
    low, high = float(entry.get("min", -math.inf)), float(entry.get("max", math.inf))
    if kind == "Boolean":
        low, high = 0.0, 1.0
    variable = Variable(
        name=entry["name"] + suffix,
        causality=causality,
        type=kind,
        unit=entry.get("unit", ""),
        start=start,
        low=low,
        high=high,
        description=entry.get("description", ""),
        tunable=bool(entry.get("tunable", False)),
    )
    if not variable.description:
        raise BuildError(f"{where}: a description is missing")
    if not variable.has_start and "start" in entry:
        raise BuildError(f"{where}: an {causality} is computed and takes no start")
    if variable.has_start and not low <= start <= high:
        raise BuildError(f"{where}: start {start} is outside [{low}, {high}]")
    if variable.unit:
        parse_unit(variable.unit)
    return variable


def _refuse_unknown(table: dict[str, Any], known: frozenset[str], where: str) -> None:
    unknown = sorted(set(table) - known)
    if unknown:
        raise BuildError(
            f"{where}: unknown key '{unknown[0]}'; known are {', '.join(sorted(known))}"
        )


def _refuse_duplicates(
    variables: list[Variable], arrays: dict[str, tuple[int, int]], path: Path
) -> None:
    names = [variable.name for variable in variables]
    for name in names:
        if names.count(name) > 1:
            raise BuildError(f"{path}: variable '{name}' is declared twice")
    macros = [c_name(name) for name in arrays]
    for macro in macros:
        if macros.count(macro) > 1:
            raise BuildError(f"{path}: two variables become {macro} in C; rename one")


def c_name(name: str) -> str:
    """Enumerator of a variable: `V_` and its name, with `_` for all that C does not allow."""
    return "V_" + re.sub(r"[^A-Za-z0-9]", "_", name)
