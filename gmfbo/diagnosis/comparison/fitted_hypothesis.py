"""A hypothesis at its best values, and what it leaves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.heard_noise import HeardNoise
from gmfbo.diagnosis.comparison.priors import Prior, coordinates_of, own_values, values_at
from gmfbo.diagnosis.comparison.whitener import Whitening
from gmfbo.diagnosis.fitting.hypothesis import Hypothesis
from gmfbo.diagnosis.runs.simulated import Simulated

Array = NDArray[np.float64]


def elements_of(hypothesis: Hypothesis, freed: Sequence[str]) -> frozenset[str]:
    """What a hypothesis adds to the twin: effects, and freed parameters as `parameter:NAME`."""
    effects = {candidate.effect for candidate in hypothesis.effects}
    return frozenset(effects | {f"parameter:{name}" for name in freed})


@dataclass(frozen=True, eq=False)
class Fitted:
    """A hypothesis at its best values.

    Attributes
    ----------
    hypothesis : Hypothesis
        With its effects at these values.
    freed : tuple of str
        Fixed parameters that it frees.
    priors : tuple of Prior
        Of its p free quantities.
    u : ndarray, shape (p,)
        Free quantities, in the coordinates of their priors.
    nuisances : ndarray, shape (q,)
        [standard deviations]
    runs : list of Simulated
        The recordings there: signals with what noise makes, where it is heard; states without it.
    values : list of ndarray, shape (m, n)
        [SI] Simulated signals of each segment.
    residual : list of ndarray, shape (m, n)
        [SI] Recorded less simulated, less the nuisances, and with what own parts make.
    columns : list of ndarray, shape (p + q, m, n)
        Change of the signals per unit of each free quantity and nuisance.
    converged : bool
        Whether the search ended by itself.
    one_sided : ndarray of bool, shape (q,)
        Nuisances without a sign.
    own : ndarray, shape (n_recordings, p)
        Own part of each free quantity in each recording, at which it was simulated; empty where
        there is none.
    heard : HeardNoise, or None
        Under which the recordings are simulated.
    under : Whitening, or None
        Under which it was fitted.
    columns_at : list of ndarray, shape (m, n)
        [SI] What was left where the columns were measured; empty where that is here.
    """

    hypothesis: Hypothesis
    freed: tuple[str, ...]
    priors: tuple[Prior, ...]
    u: Array
    nuisances: Array
    runs: list[Simulated]
    values: list[Array]
    residual: list[Array]
    columns: list[Array]
    converged: bool
    one_sided: NDArray[np.bool_]
    own: Array = field(default_factory=lambda: np.zeros((0, 0)))
    heard: HeardNoise | None = None
    under: Whitening | None = None
    columns_at: list[Array] = field(default_factory=list)

    @property
    def x(self) -> Array:
        """Values of the free quantities, shape (p,)."""
        return values_at(self.priors, self.u)

    @property
    def own_values(self) -> list[dict[str, float]]:
        """By recording, the values of quantities that have own parts."""
        return own_values(self.priors, self.hypothesis.names, self.u, self.own)

    def aside(self) -> Fitted:
        """The same with its quantities a usual difference step away; nothing is simulated."""
        sizes = self.hypothesis.moved_by({}).difference_sizes(self.x)
        u = coordinates_of(self.priors, self.x + sizes)
        return replace(self, hypothesis=self.hypothesis.at(values_at(self.priors, u)), u=u)

    def own_of(self, names: Sequence[str]) -> Array:
        """Own parts of quantities by name, shape (n_recordings, n_names); 0 of others."""
        places = {name: i for i, name in enumerate(self.hypothesis.names)}
        found = np.zeros((self.own.shape[0], len(names)))
        for k, name in enumerate(names):
            if name in places and self.own.size:
                found[:, k] = self.own[:, places[name]]
        return found

    @property
    def parameters(self) -> dict[str, float]:
        """Of the twin."""
        return self.hypothesis.parameters(self.x)

    @property
    def elements(self) -> frozenset[str]:
        """What it adds to the twin, by name."""
        return elements_of(self.hypothesis, self.freed)

    @property
    def at_zero(self) -> NDArray[np.bool_]:
        """Nuisances that rest at zero, which is a bound of those without a sign."""
        at_rest: NDArray[np.bool_] = self.nuisances == 0.0
        return at_rest & self.one_sided

    @property
    def slopes(self) -> Array:
        """Of the negative log prior in all p + q coordinates."""
        own = [p.slope(u) for p, u in zip(self.priors, self.u, strict=True)]
        return np.concatenate([own, self.nuisances])

    @property
    def curvatures(self) -> Array:
        """Of the negative log prior in all p + q coordinates."""
        own = [p.curvature(u) for p, u in zip(self.priors, self.u, strict=True)]
        return np.concatenate([own, np.ones(self.nuisances.size)])

    def beside_own_parts(self, whitening: Whitening) -> Whitening:
        """A whitening with own parts of these quantities in each recording beside."""
        return whitening.about(self.hypothesis.names, self.columns)

    @property
    def log_prior(self) -> float:
        """[nats] Density of the values and nuisances."""
        own = sum(p.log_density(u) for p, u in zip(self.priors, self.u, strict=True))
        nu = self.nuisances
        return float(own - 0.5 * nu @ nu - 0.5 * nu.size * np.log(2.0 * np.pi))
