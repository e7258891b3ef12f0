"""The budget measured by what the whole library leaves, in place of noise alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.dispersion import dispersion_of
from gmfbo.diagnosis.fitting.fit import Fitted, fit, stacked
from gmfbo.diagnosis.fitting.linear_left_out import normal_equations
from gmfbo.diagnosis.fitting.misfit import Blocks, Misfit, chi2
from gmfbo.diagnosis.naming.decision import Decision
from gmfbo.diagnosis.screening.probes import Probe


def widen_budget(case: Case, decision: Decision, fits: list[Fitted]) -> list[Fitted]:
    """Measure by what the whole library together leaves: a gain counts relative to that.

    Parameters
    ----------
    case : Case
        Twin, recordings and budget, which is changed.
    decision : Decision
        Before its first round; learns what is left.
    fits : list of Fitted
        Of the first round.

    Returns
    -------
    list of Fitted
        The same, measured by the new budget; the best may have been fitted further.
    """
    best = best_of(case.base, fits)
    if best is not case.base:
        # A fit that stopped early would pass for a law that is not exact.
        again = fit(case.misfit, best.hypothesis, best.parameters, near=best, parallel=True)
        if again is not None and again.chi2 < best.chi2:
            fits = [again if f is best else f for f in fits]
            best = again
    left = _beyond_library(case.misfit, best, decision.tried)
    _measure_by(case, decision, case.misfit, best, left)
    decision.model = case.base
    return [f.measured_by(case.misfit) for f in fits]


def best_of(model: Fitted, fits: Sequence[Fitted]) -> Fitted:
    """The fit that leaves least, of a model and of those with one effect more."""
    return min([model, *fits], key=lambda f: f.chi2)


def narrow_budget(case: Case, decision: Decision) -> None:
    """Measure by what the library leaves beside named effects, where that is less than before.

    Parameters
    ----------
    case : Case
        Twin, recordings and budget, which is changed.
    decision : Decision
        So far; all its fits are measured anew.
    """
    assert decision.model is not None
    plain = case.plain
    model = decision.model.measured_by(plain)
    left = _beyond_library(plain, model, decision.tried)
    if chi2(left) < decision.left * sum(block.size for block in left):
        _measure_by(case, decision, plain, model, left)
        decision.model = model.measured_by(case.misfit)
        decision.rounds[:] = [entry.measured_by(case.misfit) for entry in decision.rounds]
        if decision.beside_rest is not None:
            decision.beside_rest = decision.beside_rest.measured_by(case.misfit)


def _measure_by(case: Case, decision: Decision, plain: Misfit, best: Fitted, left: Blocks) -> None:
    """Let the case be measured by what is left, in place of noise alone."""
    decision.left = chi2(left) / sum(block.size for block in left)
    decision.dispersion = max(1.0, decision.left)
    spread = dispersion_of(replace(best, residual=left), plain.whiteners)
    case.use(plain.with_whiteners(case.budget.whiteners(spread)))


def _beyond_library(misfit: Misfit, best: Fitted, tried: Sequence[Probe]) -> Blocks:
    """Residual of the best model after a linear fit of every probe at once.

    What a second effect would explain must not count as noise against it.
    """
    together = best.sensitivity
    for probe in tried:
        more = stacked(misfit, probe.columns)
        together = tuple(np.concatenate([a, b]) for a, b in zip(together, more, strict=True))
    precision = np.concatenate([best.prior, *(probe.prior for probe in tried)])
    one_group = [0] * len(best.residual)
    solution = normal_equations(best.residual, together, one_group, precision).solution()
    return tuple(r - solution @ a for r, a in zip(best.residual, together, strict=True))
