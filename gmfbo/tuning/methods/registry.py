"""Methods that installed packages add, found by their entry points."""

from __future__ import annotations

from collections.abc import Iterable
from importlib.metadata import EntryPoint, entry_points

from gmfbo.errors import InputError, did_you_mean
from gmfbo.tuning.query.method import Method
from gmfbo.tuning.query.method_names import ADDED_GROUP

GROUP = "gmfbo.methods"


def added_methods() -> dict[str, Method]:
    """All methods that packages add, by name.

    Raises
    ------
    InputError
        One of them cannot be loaded, or is no method.
    """
    return {entry.name: _load(entry) for entry in entry_points(group=ADDED_GROUP)}


def method_named(name: str, known: Iterable[str]) -> Method:
    """A method that a package adds; others are not loaded.

    Parameters
    ----------
    name : str
        Of the entry point.
    known : iterable of str
        Names that gmfbo itself has, for the message.

    Raises
    ------
    InputError
        No package adds it, or it cannot be loaded, or is no method.
    """
    added = {entry.name: entry for entry in entry_points(group=ADDED_GROUP)}
    if name not in added:
        raise InputError(f"no method '{name}'" + did_you_mean(name, [*known, *added]))
    return _load(added[name])


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
