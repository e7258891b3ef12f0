"""How good was it: step metrics, their weighted cost, and the fit of a twin."""

from gmfbo.objective.cost import PAPER_WEIGHTS, Objective
from gmfbo.objective.fit import compare_at, nrmse, scored_rows
from gmfbo.objective.metrics import METRICS, step_metrics, worst_metrics

__all__ = [
    "METRICS",
    "PAPER_WEIGHTS",
    "Objective",
    "compare_at",
    "nrmse",
    "scored_rows",
    "step_metrics",
    "worst_metrics",
]
