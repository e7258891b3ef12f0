"""Judge a run: step metrics, weighted objective, limits, and the error of a twin.

`cost.Objective` weighs `metrics.step_metrics` and `own_metrics.OwnMetrics` into the objective g,
`limits.Limits` and `envelope.Envelope` state what is allowed, `fit.nrmse` compares trajectories,
and `mismatch.relative_mismatch` tells how far correcting the twin changes its objective.
"""

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
