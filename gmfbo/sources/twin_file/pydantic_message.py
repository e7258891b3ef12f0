"""Describe pydantic's list of errors of a file in one line."""

from __future__ import annotations

from typing import Any, get_args, get_origin

from pydantic import BaseModel, ValidationError

from gmfbo.errors import did_you_mean

_SHOWN = 3


def describe_problems(error: ValidationError, model: type[BaseModel]) -> str:
    """Describe the first few problems: key, expected and given value.

    Parameters
    ----------
    error : ValidationError
        Exception of the model.
    model : type
        The model, to name the keys that would be valid.
    """
    problems = list(
        dict.fromkeys(_describe(entry, model) for entry in error.errors(include_url=False))
    )
    more = len(problems) - _SHOWN
    tail = f"; and {more} more" if more > 0 else ""
    return "; ".join(problems[:_SHOWN]) + tail


def _describe(entry: Any, model: type[BaseModel]) -> str:
    place = [str(part) for part in entry["loc"]]
    if entry["type"] == "extra_forbidden":
        *table, key = place
        where = _where(table)
        return f"{where}unknown key '{key}'" + did_you_mean(key, _keys(model, table))
    if entry["type"] == "missing":
        *table, key = place
        return f"{_where(table)}'{key}' is missing"
    where = _where(place)
    if entry["type"] == "value_error":
        return f"{where}{entry['ctx']['error']}"
    expected = entry["msg"].removeprefix("Input should be ").removeprefix("a valid ")
    return f"{where}expected {expected}, got {_shown(entry['input'])}"


def _where(place: list[str]) -> str:
    """Place of a problem in the file's words: "[outputs] 'position' scale"."""
    if not place:
        return ""
    # A union's branch (`str`, `float`) is no key of the file.
    place = [part for part in place if part.isdigit() or not _is_branch(part)]
    if len(place) == 1:
        return f"{place[0]}: "
    table, name, *rest = place
    inside = f" {'.'.join(rest)}" if rest else ""
    return f"[{table}] '{name}'{inside}: "


def _is_branch(part: str) -> bool:
    return part in ("str", "float", "constrained-str", "constrained-float") or "[" in part


def _keys(model: type[BaseModel], table: list[str]) -> list[str]:
    """Valid keys of the table at this place."""
    found: object = model
    for part in table:
        if isinstance(found, type) and issubclass(found, BaseModel):
            found = found.model_fields[part].annotation if part in found.model_fields else None
        elif get_origin(found) is dict:  # the part is a name chosen by the user
            found = get_args(found)[1]
    is_model = isinstance(found, type) and issubclass(found, BaseModel)
    return list(found.model_fields) if is_model else []  # type: ignore[attr-defined]


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
