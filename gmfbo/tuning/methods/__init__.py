"""The tuning methods by name; each is a small file over the same loop and initial data."""

from __future__ import annotations

from gmfbo.errors import InputError, did_you_mean
from gmfbo.tuning.method import Method
from gmfbo.tuning.methods.bo_ei import SingleSourceImprovement
from gmfbo.tuning.methods.gmfbo import Gmfbo
from gmfbo.tuning.methods.gmfbo_kernel import KernelGmfbo
from gmfbo.tuning.methods.gmfbo_paper import PrintedGmfbo
from gmfbo.tuning.methods.random import RandomSearch

METHODS: dict[str, Method] = {
    method.name: method
    for method in (
        Gmfbo(),
        KernelGmfbo(),
        PrintedGmfbo(),
        SingleSourceImprovement(),
        RandomSearch(),
    )
}
"""Methods by name. Add one with `METHODS[mine.name] = mine`; the loop needs no change."""


def find_method(name: str) -> Method:
    """Return a method by its name.

    Raises
    ------
    InputError
        There is none of that name; the message names the nearest.
    """
    if name not in METHODS:
        raise InputError(f"no method '{name}'" + did_you_mean(name, METHODS))
    return METHODS[name]


__all__ = ["METHODS", "find_method"]
