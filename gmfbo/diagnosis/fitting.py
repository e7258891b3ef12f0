"""Fits of a hypothesis to all recordings through the FMU."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from gmfbo.diagnosis.difference_steps import with_clear_steps
from gmfbo.diagnosis.hypothesis import Hypothesis
from gmfbo.diagnosis.misfit import Blocks, Misfit, chi2
from gmfbo.diagnosis.simulated import Simulated

_ITERATIONS = 10
_TOLERANCE = 3e-4  # of chi2: far below what separates two hypotheses
_FLAT = 1e-12  # gradient where parameters change nothing, as in a recording at rest
_HOPELESS = 1e4  # residual that stands for a run which ended early


@dataclass(frozen=True, eq=False)
class Fitted:
    """A hypothesis at the values that fit best.

    Attributes
    ----------
    hypothesis : Hypothesis
        With its effects at these values.
    x : ndarray, shape (n,)
        Free parameters.
    simulated : list of Simulated
        The recordings there.
    residual : Blocks
        Recorded minus simulated, whitened, one block a window.
    sensitivity : Blocks
        Whitened change of the simulation per unit of each parameter, shape (n, n_residuals).
    columns : list
        The same before whitening: one list a parameter, of tuples of signals a recording.
    """

    hypothesis: Hypothesis
    x: NDArray[np.float64]
    simulated: list[Simulated]
    residual: Blocks
    sensitivity: Blocks
    columns: list[list[tuple[NDArray[np.float64], ...]]]

    @property
    def chi2(self) -> float:
        """Whitened sum of squares."""
        return chi2(self.residual)

    @property
    def prior(self) -> NDArray[np.float64]:
        """Precision of a weak prior of each free parameter, shape (n,)."""
        return self.hypothesis.prior

    @property
    def parameters(self) -> dict[str, float]:
        """Uncertain parameters of the twin."""
        return self.hypothesis.parameters(self.x)

    def measured_by(self, misfit: Misfit) -> Fitted:
        """Return the same fit whitened by another budget; nothing is simulated."""
        return Fitted(
            self.hypothesis,
            self.x,
            self.simulated,
            misfit.residual(self.simulated),
            stacked(misfit, self.columns),
            self.columns,
        )


def fit(
    misfit: Misfit,
    hypothesis: Hypothesis,
    parameters: Mapping[str, float],
    *,
    parallel: bool = False,
    iterations: int = _ITERATIONS,
) -> Fitted | None:
    """Fit all free parameters by least squares; None where the start cannot be simulated.

    Parameters
    ----------
    misfit : Misfit
        Recordings and budget.
    hypothesis : Hypothesis
        What is free; its effects' values are the start.
    parameters : mapping of str to float
        Start of the twin's uncertain parameters.
    parallel : bool
        Use all simulators for this fit alone.
    iterations : int
        Points that are tried at most.
    """
    if hypothesis.setting.is_rough:
        hypothesis = with_clear_steps(misfit, hypothesis, parameters, parallel=parallel)
    search = _Search(misfit, hypothesis, parallel)
    x = hypothesis.start(parameters)
    if not all(run.finite for run in search.simulate(x)):
        return None
    if x.size:
        low, high = hypothesis.bounds
        solution = least_squares(
            search.residual,
            x,
            jac=search.jacobian,
            bounds=(low, high),
            x_scale=hypothesis.scales,
            ftol=_TOLERANCE,
            xtol=1e-4,
            gtol=_FLAT,
            max_nfev=iterations,
        )
        x = solution.x
    return search.fitted(x)


def stacked(misfit: Misfit, columns: list[list[tuple[NDArray[np.float64], ...]]]) -> Blocks:
    """Whiten columns of several parameters together, shape (n, n_residuals) a window."""
    if not columns:
        return tuple(np.zeros((0, w.n_residuals)) for w in misfit.whiteners)
    records = range(len(columns[0]))
    together = [
        [np.stack(signals) for signals in zip(*(column[k] for column in columns), strict=True)]
        for k in records
    ]
    return misfit.whitened(together)


class _Search:
    """Residuals and Jacobians for SciPy, simulating no point twice."""

    def __init__(self, misfit: Misfit, hypothesis: Hypothesis, parallel: bool) -> None:
        self._misfit, self._hypothesis, self._parallel = misfit, hypothesis, parallel
        self._known: dict[bytes, list[Simulated]] = {}
        self._columns: dict[bytes, list[list[tuple[NDArray[np.float64], ...]]]] = {}
        self._length = sum(w.n_residuals for w in misfit.whiteners)

    def simulate(self, x: NDArray[np.float64]) -> list[Simulated]:
        if x.tobytes() not in self._known:
            point, runs = self._hypothesis.point(x), self._misfit.simulations
            self._known[x.tobytes()] = (
                runs.run([point])[0] if self._parallel else runs.run_here(point)
            )
        return self._known[x.tobytes()]

    def residual(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        simulated = self.simulate(x)
        if not all(run.finite for run in simulated):
            return np.full(self._length, _HOPELESS)
        return np.concatenate(self._misfit.residual(simulated))

    def jacobian(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        blocks = stacked(self._misfit, self._change(x))
        # A neighbour that could not be simulated tells nothing about its direction.
        return -np.nan_to_num(np.concatenate(blocks, axis=1)).T

    def fitted(self, x: NDArray[np.float64]) -> Fitted:
        simulated = self.simulate(x)
        columns = self._change(x)
        blocks = tuple(np.nan_to_num(block) for block in stacked(self._misfit, columns))
        return Fitted(
            self._hypothesis.at(x), x, simulated, self._misfit.residual(simulated), blocks, columns
        )

    def _change(self, x: NDArray[np.float64]) -> list[list[tuple[NDArray[np.float64], ...]]]:
        if x.tobytes() not in self._columns:
            self._columns[x.tobytes()] = self._misfit.sensitivities(
                self._hypothesis, x, self.simulate(x), parallel=self._parallel
            )
        return self._columns[x.tobytes()]
