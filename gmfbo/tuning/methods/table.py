"""A table of methods by name, each loaded when first asked for."""

from __future__ import annotations

import pkgutil
from collections.abc import Iterator, Mapping, MutableMapping
from importlib.metadata import EntryPoint, entry_points

from gmfbo.errors import InputError, did_you_mean
from gmfbo.tuning.query.method import Method

GROUP = "gmfbo.methods"
"""Entry points by which installed packages add methods."""

REMOVED = ("gmfbo_kernel", "gmfbo_smoothed", "mfbo_adaptive", "mfbo_icm", "rmfbo")
"""Methods of 0.1 that lost against those that are left; their studies can still be read."""


class MethodTable(MutableMapping[str, Method]):
    """Methods by name; a row is a method, or where one is found as `module:object`.

    Parameters
    ----------
    rows : mapping of str to str
        `module:object` by name; a class is called without arguments.
    """

    def __init__(self, rows: Mapping[str, str]) -> None:
        self._rows: dict[str, Method | str] = dict(rows)

    def add_rows(self, rows: Mapping[str, str]) -> None:
        """Add rows as `module:object`; a name that is in the table already keeps its method."""
        self._rows.update({name: row for name, row in rows.items() if name not in self._rows})

    def __getitem__(self, name: str) -> Method:
        row = self._rows[name]
        if isinstance(row, str):
            loaded = pkgutil.resolve_name(row)
            row = self._rows[name] = loaded() if isinstance(loaded, type) else loaded
        return row

    def __setitem__(self, name: str, method: Method) -> None:
        self._rows[name] = method

    def __delitem__(self, name: str) -> None:
        del self._rows[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._rows)

    def __len__(self) -> int:
        return len(self._rows)

    def find(self, name: str) -> Method:
        """As `gmfbo.tuning.methods.find_method`."""
        if name in self._rows:
            return self[name]
        added = _entry_points()
        if name in added:
            return _load(added[name])
        if name in REMOVED:
            raise InputError(
                f"method '{name}': removed in 0.2.0; use one of {', '.join([*self, *added])}"
            )
        raise InputError(f"no method '{name}'" + did_you_mean(name, [*self, *added]))

    def names(self) -> list[str]:
        """Names of the table and of what installed packages add; nothing is loaded."""
        return [*self, *_entry_points()]


def _entry_points() -> dict[str, EntryPoint]:
    return {entry.name: entry for entry in entry_points(group=GROUP)}


def _load(entry: EntryPoint) -> Method:
    try:
        loaded = entry.load()
        method = loaded() if isinstance(loaded, type) else loaded
    except Exception as error:
        reason = f"{type(error).__name__}: {error}".splitlines()[0]
        raise InputError(
            f"method '{entry.name}': cannot load {entry.value} ({reason}); "
            "repair or uninstall the package that adds it"
        ) from error
    for part in ("name", "summary", "reference", "correction", "propose", "recommend"):
        if not hasattr(method, part):
            raise InputError(
                f"method '{entry.name}': expected {entry.value} to have '{part}'; see "
                "gmfbo.tuning.method.Method for all that a method has"
            )
    if method.name != entry.name:
        raise InputError(
            f"method '{entry.name}': {entry.value} calls itself '{method.name}'; "
            "give both the same name"
        )
    checked: Method = method
    return checked
