"""The unnamed model: what is missing at a port as a free function of one state, with its band.

Each family is regressed together with the parameters' sensitivities about a fitted model, under a
prior on its values whose width is the one that predicts recordings best that were left out.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.linear_left_out import Normal, solve_weakly_bound
from gmfbo.diagnosis.fitting.misfit import Blocks
from gmfbo.diagnosis.fitting.regression import Regression, joined
from gmfbo.diagnosis.outside.state_features import Family, families
from gmfbo.diagnosis.result.whereabouts import Shape
from gmfbo.diagnosis.runs.measured_excitation import states_of
from gmfbo.diagnosis.screening.port_response import PortResponse
from gmfbo.diagnosis.screening.seen_from_port import whitened_columns
from gmfbo.physics import States

Array = NDArray[np.float64]

_WIDTHS = (1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0)  # of the range of torque or position
_ALIKE = 0.02  # of a parameter's change: what a family cannot make of it, and yet explains it
_CLEARLY = 1.02  # times the fall of chi2: less does not make a function of time of one of state
_TWO_SIDED = 1.96  # 95 % of a normal distribution


@dataclass(frozen=True, eq=False)
class UnnamedFamily:
    """One family fitted.

    Attributes
    ----------
    family : Family
        Which.
    gain : float
        Fall of chi2 on recordings left out; for a function of time, of which no other recording
        tells, that by a fit.
    gains : tuple of float
        The same of each recording.
    fall : float
        Of chi2 by a fit to all recordings, less twice what its free values take from noise
        (Akaike 1974).
    width : float
        [port's unit] Of the prior of its values.
    values : ndarray, shape (n,)
        [port's unit] Of the family's free numbers.
    covariance : ndarray, shape (n, n)
        [port's unit squared] Of these, scaled by chi2 per degree of freedom.
    excess : float
        chi2 per degree of freedom that is left, at least one.
    """

    family: Family
    gain: float
    gains: tuple[float, ...]
    fall: float
    width: float
    values: Array
    covariance: Array
    excess: float


@dataclass(frozen=True, eq=False)
class Unnamed:
    """Families fitted to what a model leaves, best first.

    Attributes
    ----------
    families : tuple of UnnamedFamily
        Best first.
    port : str
        Where they act.
    """

    families: tuple[UnnamedFamily, ...]
    _fits: Mapping[str, _FamilyFit]
    port: str

    @property
    def best(self) -> UnnamedFamily:
        """The family with the largest gain."""
        return self.families[0]

    def of(self, name: str) -> UnnamedFamily:
        """Family of a name, such as `velocity`."""
        return next(fitted for fitted in self.families if fitted.family.name == name)

    def predicted(
        self, record: int, *, without: Collection[int] = (), name: str | None = None
    ) -> tuple[Array, ...]:
        """Change of the simulated signals by a family, and by the parameters beside it.

        Parameters
        ----------
        record : int
            Which recording.
        without : collection of int
            Recordings that the fit does not see.
        name : str, optional
            Family; the best without it.
        """
        return self._fits[name or self.best.family.name].predicted(record, without)

    def shape(self, units: Mapping[str, str], name: str | None = None) -> Shape:
        """Inferred signal and its 95 % band, less what the parameters can make of it.

        Parameters
        ----------
        units : mapping of str to str
            Of `torque` (or which port it is), `position`, `velocity`; seconds for a time.
        name : str, optional
            Family; the best without it.
        """
        fitted = self.best if name is None else self.of(name)
        fit, family = self._fits[fitted.family.name], fitted.family
        values, covariance = fit.apart_from_parameters(fitted)
        values, covariance = family.turn @ values, family.turn @ covariance @ family.turn.T
        if not family.shared:
            shown = int(np.argmax(fitted.gains)) * family.knots.size
            own = slice(shown, shown + family.knots.size)
            values, covariance = values[own], covariance[own, own]
        half = _TWO_SIDED * np.sqrt(np.maximum(np.diag(covariance), 0.0))
        return Shape(
            port=self.port,
            against=family.against,
            x=_numbers(family.knots),
            y=_numbers(values),
            y_low=_numbers(values - half),
            y_high=_numbers(values + half),
            unit_x={**units, "time": "s"}.get(family.unit, ""),
            unit_y=units.get(self.port, ""),
        )


def unnamed(
    case: Case,
    base: Fitted,
    response: PortResponse,
    of: Callable[[Sequence[States]], list[Family]] = families,
) -> Unnamed:
    """Fit every family to what a model leaves."""
    records = case.simulations.records
    states = [states_of(run, record) for run, record in zip(base.simulated, records, strict=True)]
    regression = Regression(case.misfit, base)
    excitation = case.setting.excitation
    sizes = {"sensor": excitation.stroke, "command": excitation.command}
    size = sizes.get(response.port, excitation.torque)
    fits = {family.name: _FamilyFit(regression, response, family, size) for family in of(states)}
    found = [fit.fitted() for fit in fits.values()]
    return Unnamed(_ranked(found), fits, response.port)


def _ranked(found: list[UnnamedFamily]) -> tuple[UnnamedFamily, ...]:
    """Best out of sample first; a function of time has to beat it on equal terms."""
    shared = sorted((f for f in found if f.family.shared), key=lambda f: -f.gain)
    own = [f for f in found if not f.family.shared]
    if shared and own[0].fall <= _CLEARLY * shared[0].fall:
        return (*shared, *own)
    return (*own, *shared)


class _FamilyFit:
    """Regression of one family beside the parameters."""

    def __init__(
        self, regression: Regression, response: PortResponse, family: Family, size: float
    ) -> None:
        self._regression, self._response, self._family = regression, response, family
        base = regression.base
        self._own = base.x.size
        more = whitened_columns(regression.misfit, response, family.columns)
        self._columns: Blocks = joined(base.sensitivity, more)
        self._normal = regression.normal(self._columns)
        self._without = regression.normal(base.sensitivity)
        self._widths = size * np.array(_WIDTHS)
        self._best = self._with_width(self._chosen_width())

    def fitted(self) -> UnnamedFamily:
        """Gain, values and their covariance."""
        falls = self._falls(self._best)
        gains = self._gains(self._best) if self._family.shared else falls
        matrix = self._best.matrix.sum(axis=0)
        identity = np.eye(len(matrix))
        excess = self._regression.excess(self._columns)
        covariance = excess * solve_weakly_bound(matrix, identity, self._best.precision)
        return UnnamedFamily(
            self._family,
            float(gains.sum()),
            _numbers(self._by_record(gains)),
            float(falls.sum()),
            float(self._best.precision[-1] ** -0.5),
            self._best.solution()[self._own :],
            covariance[self._own :, self._own :],
            excess,
        )

    def predicted(self, record: int, without: Collection[int]) -> tuple[Array, ...]:
        groups = np.array(self._regression.groups)
        records = np.array([w.window.record for w in self._regression.misfit.whiteners])
        kept = [g for g in sorted(set(groups)) if records[groups == g][0] not in without]
        part = replace(
            self._best,
            matrix=self._best.matrix[kept],
            vector=self._best.vector[kept],
            square=self._best.square[kept],
        )
        change = part.solution()
        torque = change[self._own :] @ self._family.columns[record]
        signals = list(self._response.filtered(record, torque))
        for share, column in zip(change, self._regression.base.columns, strict=False):
            signals = [s + share * c for s, c in zip(signals, column[record], strict=True)]
        return tuple(signals)

    def apart_from_parameters(self, fitted: UnnamedFamily) -> tuple[Array, Array]:
        """Values and covariance without what parameters could as well explain.

        A slope over the velocity is viscous friction: with that among the parameters, the data
        only tell the rest.
        """
        matrix = self._normal.matrix.sum(axis=0)
        own, cross, more = self._split(matrix)
        weights = more + 1e-9 * np.trace(more) / len(more) * np.eye(len(more))
        made = np.linalg.solve(weights, cross.T)
        left = np.diag(own) - np.einsum("pn,np->p", cross, made)
        alike = made[:, left < _ALIKE * np.diag(own)]
        if not alike.shape[1]:
            return fitted.values, fitted.covariance
        onto = np.linalg.solve(alike.T @ weights @ alike, alike.T @ weights)
        rest = np.eye(len(more)) - alike @ onto
        return rest @ fitted.values, rest @ fitted.covariance @ rest.T

    def _split(self, matrix: Array) -> tuple[Array, Array, Array]:
        n = self._own
        return matrix[:n, :n], matrix[:n, n:], matrix[n:, n:]

    def _with_width(self, width: float) -> Normal:
        precision = self._normal.precision.copy()
        precision[self._own :] = np.where(self._family.bends, width, self._widths[-1]) ** -2.0
        return replace(self._normal, precision=precision)

    def _chosen_width(self) -> float:
        judged = self._gains if self._family.shared else self._falls
        gains = [float(judged(self._with_width(width)).sum()) for width in self._widths]
        return float(self._widths[int(np.argmax(gains))])

    def _gains(self, normal: Normal) -> Array:
        """Fall of chi2 by the family of each group that is left out."""
        gains: Array = self._without.left_out() - normal.left_out()
        return gains

    def _falls(self, normal: Normal) -> Array:
        """Fall of chi2 of each group by a fit to all, less twice what is taken from noise."""
        matrix = normal.matrix[:, self._own :, self._own :]
        prior = np.diag(normal.precision[self._own :])
        whole = np.linalg.inv(matrix.sum(axis=0) + prior)
        taken = np.einsum("gij,ji->g", matrix, whole)
        fall = self._without.fitted() - normal.fitted()
        falls: Array = fall - 2.0 * self._regression.excess(self._columns) * taken
        return falls

    def _by_record(self, gains: Array) -> Array:
        groups = np.array(self._regression.groups)
        records = np.array([w.window.record for w in self._regression.misfit.whiteners])
        total = np.zeros(records.max() + 1)
        for g, gain in enumerate(gains):
            total[records[groups == g][0]] += gain
        return total


def _numbers(values: Array) -> tuple[float, ...]:
    return tuple(float(value) for value in values)
