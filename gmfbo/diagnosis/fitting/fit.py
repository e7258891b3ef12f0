"""Fits of a hypothesis to all recordings through the FMU."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from gmfbo.diagnosis.fitting.difference_steps import with_clear_steps
from gmfbo.diagnosis.fitting.hypothesis import Hypothesis
from gmfbo.diagnosis.fitting.misfit import Blocks, Misfit, chi2
from gmfbo.diagnosis.runs.simulated import Simulated

_ITERATIONS = 10
_TO_THE_END = 40  # 2.5 times the 16 that a plant with a long dead time took from nominal values
_CHEAP = 20  # most points of a search with a kept Jacobian
_TOLERANCE = 3e-4  # of chi2: far below what separates two hypotheses
_FLAT = 1e-12  # gradient below which parameters change nothing, as in a recording at rest
_HOPELESS = 1e4  # residual assigned to a run that ended early
_FAR = 2.0  # chi2 per degree of freedom above which a model's Jacobian is not reused
_SHORTFALL = 0.25  # of the predicted fall of chi2: further short of it, the Jacobian is renewed

Array = NDArray[np.float64]
Columns = list[tuple[Array, ...]]
"""Change of each recording's signals per unit of one parameter."""


@dataclass(frozen=True, eq=False)
class Fitted:
    """A hypothesis at its best fitting values.

    Attributes
    ----------
    hypothesis : Hypothesis
        With its effects at these values.
    x : ndarray, shape (n,)
        Free parameters.
    simulated : list of Simulated
        The recordings simulated there.
    residual : Blocks
        Recorded minus simulated, whitened, one block a window.
    sensitivity : Blocks
        Whitened change of the simulation per unit of each parameter, shape (n, n_residuals).
    columns : list
        Sensitivities before whitening: for each parameter and recording, one array a signal.
    converged : bool
        Whether chi2 or the values no longer moved; False where the points allowed were used up.
    """

    hypothesis: Hypothesis
    x: Array
    simulated: list[Simulated]
    residual: Blocks
    sensitivity: Blocks
    columns: list[Columns]
    converged: bool = True

    @property
    def chi2(self) -> float:
        """Whitened sum of squares."""
        return chi2(self.residual)

    @property
    def prior(self) -> Array:
        """Precision of a weak prior of each free parameter, shape (n,)."""
        return self.hypothesis.prior

    @property
    def parameters(self) -> dict[str, float]:
        """Uncertain parameters of the twin."""
        return self.hypothesis.parameters(self.x)

    def measured_by(self, misfit: Misfit) -> Fitted:
        """The same fit whitened by another budget; nothing is simulated."""
        return replace(
            self,
            residual=misfit.residual(self.simulated),
            sensitivity=stacked(misfit, self.columns),
        )


def fit(
    misfit: Misfit,
    hypothesis: Hypothesis,
    parameters: Mapping[str, float],
    *,
    near: Fitted | None = None,
    parallel: bool = False,
    iterations: int = _ITERATIONS,
) -> Fitted | None:
    """Fit all free parameters by least squares; None where the start cannot be simulated.

    The Jacobian changes little from step to step, and with one effect more. Near a model that has
    effects and fits well, the search begins with that model's Jacobian and keeps it (the chord
    method; Ortega, Rheinboldt 1970, section 7.1) until a step falls short of its predicted gain.
    A second search from its end measures the Jacobian at each step.

    Parameters
    ----------
    misfit : Misfit
        Recordings and budget.
    hypothesis : Hypothesis
        Its free parameters; the values of its effects are the start.
    parameters : mapping of str to float
        Start of the twin's uncertain parameters.
    near : Fitted, optional
        A fit of a similar hypothesis, whose Jacobian is reused.
    parallel : bool
        Use all simulators for this fit alone.
    iterations : int
        Most points with a measured Jacobian.
    """
    if hypothesis.setting.is_rough:
        hypothesis = with_clear_steps(misfit, hypothesis, parameters, parallel=parallel)
    search = _Search(misfit, hypothesis, parallel, near)
    x = hypothesis.start(parameters)
    if not all(run.finite for run in search.simulate(x)):
        return None
    if x.size:
        if search.has_columns:
            x = search.solution(x, _CHEAP)
            search.forget()
        x = search.solution(x, iterations)
    return search.fitted(x)


def fit_to_the_end(
    misfit: Misfit,
    hypothesis: Hypothesis,
    parameters: Mapping[str, float],
    *,
    near: Fitted | None = None,
) -> Fitted | None:
    """Fit values that are reported: the fit goes on until chi2 no longer falls.

    Parameters
    ----------
    misfit, hypothesis, parameters, near
        As of `fit`; all simulators are used.

    Returns
    -------
    Fitted or None
        `converged` is false where 40 points did not suffice.
    """
    return fit(misfit, hypothesis, parameters, near=near, parallel=True, iterations=_TO_THE_END)


def stacked(misfit: Misfit, columns: list[Columns]) -> Blocks:
    """Whiten columns of several parameters together, shape (n, n_residuals) a window."""
    if not columns:
        return tuple(np.zeros((0, w.n_residuals)) for w in misfit.whiteners)
    records = range(len(columns[0]))
    together = [
        [np.stack(signals) for signals in zip(*(column[k] for column in columns), strict=True)]
        for k in records
    ]
    return misfit.whitened(together)


def _is_near(model: Fitted) -> bool:
    """Whether a model's Jacobian is worth reusing: it has effects and fits well."""
    residuals = sum(block.size for block in model.residual)
    return bool(model.hypothesis.effects) and model.chi2 < _FAR * residuals


class _Search:
    """Residuals and Jacobians for SciPy, simulating no point twice."""

    def __init__(
        self, misfit: Misfit, hypothesis: Hypothesis, parallel: bool, near: Fitted | None
    ) -> None:
        self._misfit, self._hypothesis, self._parallel = misfit, hypothesis, parallel
        self._known: dict[bytes, list[Simulated]] = {}
        self._columns: dict[tuple[bytes, int], Columns] = {}
        self._length = sum(w.n_residuals for w in misfit.whiteners)
        self._near: dict[str, Columns] = {}
        if near is not None and _is_near(near):
            self._near = dict(zip(near.hypothesis.names, near.columns, strict=True))
        self._last: tuple[Array, Array] | None = None
        self._converged = True

    @property
    def has_columns(self) -> bool:
        return bool(self._near)

    def forget(self) -> None:
        """Measure the whole Jacobian at each step from here on."""
        self._near, self._last = {}, None

    def solution(self, x: Array, steps: int) -> Array:
        found = least_squares(
            self.residual,
            x,
            jac=self.jacobian,
            bounds=self._hypothesis.bounds,
            x_scale=self._hypothesis.scales,
            ftol=_TOLERANCE,
            xtol=1e-4,
            gtol=_FLAT,
            max_nfev=steps,
        )
        self._converged = bool(found.status > 0)  # 0: all points were used up
        return np.asarray(found.x)

    def simulate(self, x: Array) -> list[Simulated]:
        if x.tobytes() not in self._known:
            point, runs = self._hypothesis.point(x), self._misfit.simulations
            self._known[x.tobytes()] = (
                runs.run([point])[0] if self._parallel else runs.run_here(point)
            )
        return self._known[x.tobytes()]

    def residual(self, x: Array) -> Array:
        simulated = self.simulate(x)
        if not all(run.finite for run in simulated):
            return np.full(self._length, _HOPELESS)
        return np.concatenate(self._misfit.residual(simulated))

    def jacobian(self, x: Array) -> Array:
        if not self._near or (self._last is not None and self._was_misled(*self._last, x)):
            slopes = self._slopes(self._change(x))
        elif self._last is None:
            names = list(enumerate(self._hypothesis.names))
            new = [i for i, name in names if name not in self._near]
            measured = dict(zip(new, self._measured(x, new), strict=True))
            slopes = self._slopes(
                [measured[i] if i in measured else self._near[name] for i, name in names]
            )
        else:
            slopes = self._last[1]
        self._last = x, slopes
        return slopes

    def _was_misled(self, before: Array, slopes: Array, x: Array) -> bool:
        """Whether a step fell short of the gain that the Jacobian predicted."""
        there, here = self.residual(before), self.residual(x)
        promised = there + slopes @ (x - before)
        missing = here @ here - promised @ promised
        return bool(missing > _SHORTFALL * (there @ there - promised @ promised))

    def _slopes(self, columns: list[Columns]) -> Array:
        blocks = stacked(self._misfit, columns)
        # A run that ended early gives no derivative in its direction.
        return -np.nan_to_num(np.concatenate(blocks, axis=1)).T

    def fitted(self, x: Array) -> Fitted:
        simulated = self.simulate(x)
        columns = self._change(x)
        blocks = tuple(np.nan_to_num(block) for block in stacked(self._misfit, columns))
        return Fitted(
            self._hypothesis.at(x),
            x,
            simulated,
            self._misfit.residual(simulated),
            blocks,
            columns,
            self._converged,
        )

    def _change(self, x: Array) -> list[Columns]:
        return self._measured(x, range(x.size))

    def _measured(self, x: Array, which: Sequence[int]) -> list[Columns]:
        at = x.tobytes()
        missing = [i for i in which if (at, i) not in self._columns]
        found = self._misfit.sensitivities(
            self._hypothesis, x, self.simulate(x), missing, parallel=self._parallel
        )
        self._columns |= {(at, i): column for i, column in zip(missing, found, strict=True)}
        return [self._columns[at, i] for i in which]
