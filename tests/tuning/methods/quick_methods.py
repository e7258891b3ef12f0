"""The methods with less effort where their default takes long, for tests of the loop."""

from __future__ import annotations

from dataclasses import replace

from gmfbo.tuning.methods import METHODS
from gmfbo.tuning.query.method import Method

SURVEY, CLOSER = 12, 2
"""Runs of the twin over the box, and in a stage of a closer look: most of a test's time."""


def _quick(method: Method) -> Method:
    options = method.correction
    if options is None or not options.survey:
        return method
    small = replace(options, survey=SURVEY, closer=min(options.closer, CLOSER))
    changed: Method = replace(method, correction=small)  # type: ignore[type-var]
    return changed


QUICK: dict[str, Method] = {name: _quick(method) for name, method in METHODS.items()}
