"""Tuning methods by name: each a small file over the same loop and initial data.

A user adds one without touching the loop: `METHODS[mine.name] = mine` from Python, or in a
package of one's own, in `pyproject.toml`, under the name that a study file gives,

    [project.entry-points."gmfbo.methods"]
    mine = "my_package.my_module:MyMethod"

What it must have is `gmfbo.tuning.method.Method`. A class is called without arguments.
"""

from __future__ import annotations

from gmfbo.tuning.methods.table import MethodTable
from gmfbo.tuning.query.method import Method

METHODS = MethodTable(
    {
        "gmfbo": "gmfbo.tuning.methods.gmfbo:Gmfbo",
        "gmfbo_paper": "gmfbo.tuning.methods.gmfbo_paper:PrintedGmfbo",
        "mfbo_caei": "gmfbo.tuning.methods.mfbo_caei:CostAwareMultiFidelity",
        "mfbo_takg": "gmfbo.tuning.methods.mfbo_takg:MultiFidelityKnowledgeGradient",
        "bo_ei": "gmfbo.tuning.methods.bo_ei:SingleSourceImprovement",
        "twin_once": "gmfbo.tuning.methods.twin_once:TwinOnce",
        "random": "gmfbo.tuning.methods.random:RandomSearch",
    }
)
"""Methods of gmfbo by name, and those added from Python; a method loads when it is looked up."""


def all_methods() -> dict[str, Method]:
    """Methods of gmfbo and those of installed packages, by name.

    Raises
    ------
    InputError
        A package's method cannot be loaded, or is none.
    """
    return {name: METHODS.find(name) for name in METHODS.names()}


def find_method(name: str) -> Method:
    """Return a method by its name, as a study file gives it.

    Parameters
    ----------
    name : str
        Of gmfbo, added from Python, or added by an installed package.

    Raises
    ------
    InputError
        There is none of that name (the message names the nearest), it was removed, or the
        package that adds it is broken.
    """
    return METHODS.find(name)


__all__ = ["METHODS", "all_methods", "find_method"]
