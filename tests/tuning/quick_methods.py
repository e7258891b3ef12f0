"""The methods with less effort where their default takes long, for tests of the loop."""

from __future__ import annotations

from dataclasses import replace

from gmfbo.tuning.method import Method
from gmfbo.tuning.methods import METHODS
from gmfbo.tuning.methods.mfbo_takg import MultiFidelityKnowledgeGradient

SURVEY = 25
"""Runs of the twin over the box; the methods' own surveys take most of a test's time."""


def _quick(method: Method) -> Method:
    options = method.correction
    if options is None or not options.survey:
        return method
    changed: Method = replace(method, correction=replace(options, survey=SURVEY))  # type: ignore[type-var]
    return changed


QUICK: dict[str, Method] = {
    **{name: _quick(method) for name, method in METHODS.items()},
    "mfbo_takg": replace(
        MultiFidelityKnowledgeGradient(), fantasies=4, restarts=1, raw_samples=8, iterations=10
    ),
}
