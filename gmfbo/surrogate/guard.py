"""When a twin is no longer trusted: it loses to the real runs alone on real runs left out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.stats import wilcoxon

from gmfbo.errors import InputError


@dataclass(frozen=True)
class TwinGuard:
    """Compares errors of predicting left-out real runs with the twin and without it.

    A one-sided signed-rank test (Wilcoxon 1945) of |error with the twin| - |error without|: it
    looks at ranks, so that one run whose settling time jumps decides nothing. The guard has no
    memory: a twin that is corrected well enough later on is trusted again.

    Attributes
    ----------
    level : float
        Share of decisions at which a twin that is as good as none is dropped.
    least_runs : int
        Left-out runs below which the twin is trusted; fewer than 4 cannot reach a level of 0.1.
    """

    level: float = 0.1
    least_runs: int = 5

    def __post_init__(self) -> None:
        if not 0.0 < self.level < 1.0 or self.least_runs < 1:
            raise InputError(
                f"expected a level within (0, 1) and at least one run, got level {self.level} "
                f"and {self.least_runs} runs"
            )

    def trusts(self, with_twin: ArrayLike, alone: ArrayLike) -> bool:
        """Whether the twin is to be used for the next proposal.

        Parameters
        ----------
        with_twin, alone : array_like, shape (n,)
            [g] Errors of predicting each real run from the others; pairs with NaN do not count.

        Raises
        ------
        InputError
            The errors are not of the same runs.
        """
        twin, single = np.abs(np.asarray(with_twin)), np.abs(np.asarray(alone))
        if twin.ndim != 1 or twin.shape != single.shape:
            raise InputError(
                f"expected errors of the same runs, got shapes {twin.shape} and {single.shape}"
            )
        loss = twin - single
        loss = loss[np.isfinite(loss) & (loss != 0.0)]
        if len(loss) < self.least_runs:
            return True
        return bool(wilcoxon(loss, alternative="greater").pvalue > self.level)
