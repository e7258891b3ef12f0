"""Write and read `diagnosis.json`."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass
from functools import cache
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

from gmfbo.diagnosis.result.findings import Findings
from gmfbo.diagnosis.result.named_effect import DetectableSize, NamedEffect
from gmfbo.errors import InputError

SCHEMA = 2
NOT_IN_JSON = ("curves", "augmentation", "exported", "next_reference")
DERIVED: Mapping[type, tuple[str, ...]] = {
    Findings: ("statement_probability",),
    NamedEffect: ("set", "set_probability"),
}
"""Properties that are written beside the fields, for other programs, and not read back."""


F = TypeVar("F", bound=Findings)


class _Misfit(Exception):
    """A value that contradicts the schema; the message says where."""


def diagnosis_text(diagnosis: Findings) -> str:
    """Return a diagnosis as JSON, schema 2, with a line end; NaN and infinities become null."""
    content = {"schema": SCHEMA, **_plain(diagnosis)}
    return json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def read_diagnosis(kind: type[F], path: Path, *, also: tuple[int, ...] = ()) -> F:
    """Read a `diagnosis.json`.

    Parameters
    ----------
    kind : type
        `Findings`, or a class that adds no fields to it.
    path : Path
        The file, or the folder that holds it.
    also : tuple of int
        Older schemas that will do; what they lack keeps its default.

    Returns
    -------
    Findings
        Without curves; `exported` is the `augmented.toml` beside it, if there is one.

    Raises
    ------
    InputError
        There is no such file, or its content is of another schema.
    """
    path = path / "diagnosis.json" if path.is_dir() else path
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(
            f"no diagnosis at '{path}' ({error.strerror}); expected the diagnosis.json that "
            "'gmfbo diagnose' wrote"
        ) from None
    except ValueError as error:
        raise InputError(f"{path.name}: expected JSON, but {error}; diagnose again") from None
    schema = content.get("schema") if isinstance(content, dict) else None
    if schema not in (SCHEMA, *also):
        raise InputError(f"{path.name}: {_whose(content, schema)}; diagnose again")
    try:
        values = _fields(kind, content, path.name)
    except _Misfit as misfit:
        raise InputError(f"{misfit}; diagnose again") from None
    twin_file = path.with_name("augmented.toml")
    return kind(**values, exported=twin_file if twin_file.is_file() else None)


def _whose(content: Any, schema: Any) -> str:
    """Words for a file of another schema: the version that wrote it, where that is known."""
    if schema == 1:
        made = content.get("versions")
        version = made.get("gmfbo", "0.1") if isinstance(made, dict) else "0.1"
        return f"made by gmfbo {version}, of schema 1 where {SCHEMA} is expected"
    return f"expected schema {SCHEMA}, got {schema}"


def _plain(value: Any) -> Any:
    if isinstance(value, DetectableSize):
        return {value.parameter: _plain(value.size), "unit": value.unit}
    if is_dataclass(value):
        names = [field.name for field in fields(value) if field.name not in NOT_IN_JSON]
        for kind, derived in DERIVED.items():
            names += derived if isinstance(value, kind) else ()
        return {name: _plain(getattr(value, name)) for name in names}
    if isinstance(value, Mapping):
        return {str(name): _plain(item) for name, item in value.items()}
    if isinstance(value, (tuple, list)):
        return [_plain(item) for item in value]
    if isinstance(value, (str, bool, NoneType)):
        return value
    if isinstance(value, int):
        return value
    number = float(value)  # NumPy's scalars too
    return number if math.isfinite(number) else None


@cache
def _hints(kind: type) -> dict[str, Any]:
    return get_type_hints(kind)


def _fields(kind: type, content: Any, where: str) -> dict[str, Any]:
    """Values of a dataclass's fields; what is absent keeps the field's default."""
    if not isinstance(content, dict):
        raise _Misfit(f"{where}: expected names with values, got {content!r}")
    known = [field.name for field in fields(kind) if field.name not in NOT_IN_JSON]
    missing = [
        field.name
        for field in fields(kind)
        if field.name in known and field.name not in content and _is_required(field)
    ]
    if missing:
        raise _Misfit(f"{where}: expected '{missing[0]}', which is not there")
    return {
        name: _value(_hints(kind)[name], content[name], f"{where}: {name}")
        for name in known
        if name in content
    }


def _is_required(field: Any) -> bool:
    return field.default is MISSING and field.default_factory is MISSING


def _value(kind: Any, content: Any, where: str) -> Any:
    if get_origin(kind) in (Union, UnionType):
        inner = next(part for part in get_args(kind) if part is not NoneType)
        return None if content is None else _value(inner, content, where)
    if get_origin(kind) is Literal:
        if content not in get_args(kind):
            raise _Misfit(f"{where}: expected one of {', '.join(get_args(kind))}, got {content!r}")
        return content
    if get_origin(kind) is tuple:
        if not isinstance(content, list):
            raise _Misfit(f"{where}: expected a list, got {content!r}")
        return tuple(_value(get_args(kind)[0], item, where) for item in content)
    if get_origin(kind) is Mapping:
        if not isinstance(content, dict):
            raise _Misfit(f"{where}: expected names with values, got {content!r}")
        inner = get_args(kind)[1]
        return {name: _value(inner, item, f"{where}.{name}") for name, item in content.items()}
    if kind is DetectableSize:
        return _detectable(content, where)
    if isinstance(kind, type) and is_dataclass(kind):
        return kind(**_fields(kind, content, where))
    if issubclass(kind, tuple):
        return _row(kind, content, where)
    return _scalar(kind, content, where)


def _detectable(content: Any, where: str) -> DetectableSize:
    if not isinstance(content, dict) or len(content) != 2 or "unit" not in content:
        raise _Misfit(f"{where}: expected one size and its unit, got {content!r}")
    name = next(key for key in content if key != "unit")
    return DetectableSize(
        name, _scalar(float, content[name], where), _scalar(str, content["unit"], where)
    )


def _row(kind: Any, content: Any, where: str) -> Any:
    kinds = list(_hints(kind).values())
    if not isinstance(content, list) or len(content) != len(kinds):
        raise _Misfit(f"{where}: expected {len(kinds)} values, got {content!r}")
    return kind(*(_scalar(one, item, where) for one, item in zip(kinds, content, strict=True)))


def _scalar(kind: type, content: Any, where: str) -> Any:
    if kind is float:
        if content is None:
            return math.nan
        if isinstance(content, (int, float)) and not isinstance(content, bool):
            return float(content)
    elif isinstance(content, kind) and not (kind is int and isinstance(content, bool)):
        return content
    what = {float: "a number", int: "a whole number", str: "text", bool: "true or false"}[kind]
    raise _Misfit(f"{where}: expected {what}, got {content!r}")
