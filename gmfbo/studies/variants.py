"""Variants of a study file: a key takes several values."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import tomli_w
from pydantic import ValidationError

from gmfbo.errors import InputError
from gmfbo.files.toml_text import parse_toml
from gmfbo.sources.twin_file.pydantic_message import describe_problems
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.study_file.study_sections import StudyFile, stated


def parse_variation(text: str) -> tuple[str, list[Any]]:
    """Parse a key and its values from `KEY = [VALUE, ...]` in TOML.

    Parameters
    ----------
    text : str
        Such as `is2.parameters."map.noise" = [0.25, 0.5]`.

    Raises
    ------
    InputError
        The text is no such line.
    """
    key, _, values = text.partition("=")
    try:
        found = _at(parse_toml(text), _path(key))
    except (ValueError, KeyError, TypeError):
        found = None
    if not isinstance(found, list) or not found or not values:
        raise InputError(
            f"vary: expected a key of the study file and a list of values in TOML, such as "
            f"'budget.initial_is1 = [1, 2]', got '{text}'"
        )
    return key.strip(), found


def variation_text(key: str, values: Sequence[Any]) -> str:
    """Text that `parse_variation` reads."""
    return f"{key} = {tomli_w.dumps({'v': list(values)}).partition('=')[2].strip()}"


def variants(study: Study, vary: Mapping[str, Sequence[Any]]) -> list[Study]:
    """The study itself where nothing varies, else one for each combination of values.

    Parameters
    ----------
    study : Study
        As given.
    vary : mapping of str to sequence
        Key of the study file, as in TOML, and the values it takes.

    Raises
    ------
    InputError
        A key is invalid, or the study file refuses a value.
    """
    if not vary:
        return [study]
    paths = [_path(key) for key in vary]
    return [
        _variant(study, list(zip(paths, values, strict=True)))
        for values in itertools.product(*vary.values())
    ]


def _variant(study: Study, settings: Sequence[tuple[tuple[str, ...], Any]]) -> Study:
    content, name = stated(study.file), study.file.name
    for path, value in settings:
        table = content
        for key in path[:-1]:
            table = table.setdefault(key, {})
            if not isinstance(table, dict):
                raise InputError(f"vary: '{'.'.join(path)}' is no key of a study file")
        table[path[-1]] = value
        name += f",{'.'.join(path)}={value}"
    content["name"] = name.replace("/", "_").replace("\\", "_")
    try:
        file = StudyFile.model_validate(content)
    except ValidationError as error:
        raise InputError(f"vary: {name}: {describe_problems(error, StudyFile)}") from None
    return replace(study, file=file)


def _path(key: str) -> tuple[str, ...]:
    """Keys of a dotted TOML key, quoted parts whole."""
    try:
        parsed = parse_toml(f"{key} = 0")
    except ValueError:
        raise InputError(f"vary: expected a key as in TOML, got '{key.strip()}'") from None
    path = []
    node: Any = parsed
    while isinstance(node, dict):
        ((name, node),) = node.items()
        path.append(name)
    return tuple(path)


def _at(table: Any, path: Sequence[str]) -> Any:
    for key in path:
        table = table[key]
    return table
