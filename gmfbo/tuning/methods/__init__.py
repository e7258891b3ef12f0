"""Tuning methods by name: each a small file over the same loop and initial data.

A user adds one without touching the loop: `METHODS[mine.name] = mine` from Python, or in a
package of one's own, in `pyproject.toml`, under the name that a study file gives,

    [project.entry-points."gmfbo.methods"]
    mine = "my_package.my_module:MyMethod"

What it must have is `gmfbo.tuning.method.Method`. A class is called without arguments.
"""

from __future__ import annotations

from gmfbo.tuning.methods.bo_ei import SingleSourceImprovement
from gmfbo.tuning.methods.gmfbo import Gmfbo
from gmfbo.tuning.methods.gmfbo_kernel import KernelGmfbo
from gmfbo.tuning.methods.gmfbo_paper import PrintedGmfbo
from gmfbo.tuning.methods.mfbo_adaptive import AdaptiveMultiFidelity
from gmfbo.tuning.methods.mfbo_caei import CostAwareMultiFidelity
from gmfbo.tuning.methods.mfbo_icm import CoregionalisedMultiFidelity
from gmfbo.tuning.methods.mfbo_takg import MultiFidelityKnowledgeGradient
from gmfbo.tuning.methods.random import RandomSearch
from gmfbo.tuning.methods.registry import added_methods, method_named
from gmfbo.tuning.methods.rmfbo import RobustMultiFidelity
from gmfbo.tuning.methods.twin_once import TwinOnce
from gmfbo.tuning.query.method import Method

METHODS: dict[str, Method] = {
    method.name: method
    for method in (
        Gmfbo(),
        KernelGmfbo(),
        PrintedGmfbo(),
        AdaptiveMultiFidelity(),
        CoregionalisedMultiFidelity(),
        CostAwareMultiFidelity(),
        MultiFidelityKnowledgeGradient(),
        RobustMultiFidelity(),
        SingleSourceImprovement(),
        TwinOnce(),
        RandomSearch(),
    )
}
"""Methods of gmfbo by name, and those added from Python."""


def all_methods() -> dict[str, Method]:
    """Methods of gmfbo and those of installed packages, by name.

    Raises
    ------
    InputError
        A package's method cannot be loaded, or is none.
    """
    return {**added_methods(), **METHODS}


def find_method(name: str) -> Method:
    """Return a method by its name.

    Parameters
    ----------
    name : str
        As in a study file.

    Raises
    ------
    InputError
        There is none of that name (the message names the nearest), or the package that adds it
        is broken.
    """
    return METHODS[name] if name in METHODS else method_named(name, METHODS)


__all__ = ["METHODS", "all_methods", "find_method"]
