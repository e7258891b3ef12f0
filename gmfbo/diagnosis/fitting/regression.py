"""Linear regression of a model's residual on columns, scored out of sample."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.linear_left_out import Normal, normal_equations
from gmfbo.diagnosis.fitting.misfit import Blocks, Misfit, chi2


class Regression:
    """Regression of a fitted model's residual on columns.

    Whole recordings are left out in turn; one recording alone is left out in parts.

    Parameters
    ----------
    misfit : Misfit
        Recordings and budget.
    base : Fitted
        The model whose residual is explained.
    """

    def __init__(self, misfit: Misfit, base: Fitted) -> None:
        self.misfit, self.base = misfit, base
        windows = [w.window.record for w in misfit.whiteners]
        self.groups = windows if len(set(windows)) > 1 else list(range(len(windows)))
        self._dof = sum(w.n_residuals for w in misfit.whiteners)

    def normal(self, columns: Blocks) -> Normal:
        """Normal equations of columns, those of the model's own parameters first."""
        free = np.zeros(len(columns[0]) - self.base.x.size)
        precision = np.concatenate([self.base.prior, free])
        return normal_equations(self.base.residual, columns, self.groups, precision)

    def left(self, columns: Blocks) -> Blocks:
        """Residual after a fit of columns."""
        solution = self.normal(columns).solution()
        return tuple(r - solution @ a for r, a in zip(self.base.residual, columns, strict=True))

    def excess(self, columns: Blocks) -> float:
        """chi2 per degree of freedom after a fit, at least one."""
        return max(1.0, chi2(self.left(columns)) / self._dof)

    def gains(
        self, own: Blocks, more: Blocks, choices: Sequence[Sequence[int]]
    ) -> NDArray[np.float64]:
        """Fall of left-out chi2 by further columns, beside columns that are fitted anyway.

        Parameters
        ----------
        own : Blocks
            Columns that are fitted anyway.
        more : Blocks
            Further ones.
        choices : sequence of sequences of int
            Further columns that are added, for each choice.

        Returns
        -------
        ndarray, shape (n_choices,)
        """
        n = len(own[0])
        whole = self.normal(joined(own, more))
        without = whole.only(range(n)).left_out().sum()
        gains = [
            without - whole.only([*range(n), *(n + i for i in choice)]).left_out().sum()
            for choice in choices
        ]
        return np.array(gains)


def joined(own: Blocks, more: Blocks) -> Blocks:
    """Both sets of columns as one."""
    return tuple(np.concatenate([a, b]) for a, b in zip(own, more, strict=True))
