"""The methods with less effort where their default takes long, for tests of the loop."""

from __future__ import annotations

from dataclasses import replace

from gmfbo.tuning.method import Method
from gmfbo.tuning.methods import METHODS
from gmfbo.tuning.methods.mfbo_takg import MultiFidelityKnowledgeGradient

QUICK: dict[str, Method] = {
    **METHODS,
    "mfbo_takg": replace(
        MultiFidelityKnowledgeGradient(), fantasies=4, restarts=1, raw_samples=8, iterations=10
    ),
}
