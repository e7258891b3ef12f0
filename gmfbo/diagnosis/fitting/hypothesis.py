"""Hypotheses about the twin: its uncertain parameters and a set of left-out effects."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.runs.simulated import Point
from gmfbo.physics import CATALOGUE, Effect, Excitation
from gmfbo.physics.effect import EffectParameter
from gmfbo.sources.twin.uncertain import Uncertain

DIFFERENCE_STEP = 5e-3
"""Share of a parameter's scale; 1e-8 would be lost in dead bands and encoder counts."""

PRIOR_WIDTH = 3.0
"""Standard deviation of a weak prior of an effect's parameters, in typical sizes."""

_PARAMETER_WIDTH = 0.3  # the same for the twin's own
_INSIDE = 1e-6  # share of a range by which values stay off its ends


@dataclass(frozen=True)
class Candidate:
    """An effect with the values from which its fit starts.

    Attributes
    ----------
    effect : str
        Name in the catalogue.
    values : mapping of str to float
        Of its fitted parameters.
    more : mapping of str to float
        Further variables of it that stay as they are.
    only : int or None
        The recording in which it acts, where that is one.
    """

    effect: str
    values: Mapping[str, float]
    more: Mapping[str, float] = field(default_factory=dict)
    only: int | None = None

    @property
    def law(self) -> Effect:
        """The effect in the catalogue."""
        return CATALOGUE[self.effect]

    @property
    def parameters(self) -> tuple[EffectParameter, ...]:
        """Fitted parameters; of an effect with several lines, those of the lines it starts with."""
        law = self.law
        return tuple(p for p in (*law.parameters, *law.own_nuisances) if p.name in self.values)

    @property
    def searched(self) -> int:
        """Number of lines and instants of the effect that were found by a search."""
        return max(
            sum(p.name.startswith("wavenumber_") for p in self.parameters), self.law.is_searched
        )

    def with_nuisances(self, excitation: Excitation) -> Candidate:
        """Return the same effect with its own nuisances among its values, at their usual ones."""
        usual = self.law.fixed(excitation)
        own = {p.name: usual[p.name] for p in self.law.own_nuisances}
        return replace(self, values={**own, **self.values})

    def as_limit(self, name: str, excitation: Excitation) -> Candidate | None:
        """Return a simpler effect at the values that this one has, None if some are lacking.

        Parameters
        ----------
        name : str
            The simpler effect, which this one holds.
        excitation : Excitation
            For what it has beside them.
        """
        same = self.law.as_limit
        values = {same[p]: value for p, value in self.values.items() if p in same}
        law = CATALOGUE[name]
        values |= {p.name: self.values[p.name] for p in law.own_nuisances if p.name in self.values}
        if not {p.name for p in law.parameters} <= values.keys():
            return None
        return Candidate(name, values).with_nuisances(excitation)

    def with_values(self, values: Mapping[str, float]) -> Candidate:
        """Return the same effect at other values."""
        return replace(self, values=dict(values))


@dataclass(frozen=True, eq=False)
class Setting:
    """Settings common to all hypotheses.

    Attributes
    ----------
    uncertain : tuple of Uncertain
        Parameters of the twin that every hypothesis refits.
    excitation : Excitation
        Ranges that the recordings cover; bounds and scales follow from them.
    inertia : str or None
        Parameter of the twin from which a load inertia is taken.
    least_inertia : float
        [FMU's unit] Below which the FMU refuses it.
    difference_steps : mapping of str to float
        Share of its scale by which a free parameter is moved; `DIFFERENCE_STEP` unless given.
    """

    uncertain: tuple[Uncertain, ...]
    excitation: Excitation
    inertia: str | None = None
    least_inertia: float = 0.0
    difference_steps: Mapping[str, float] = field(default_factory=dict)

    @property
    def is_rough(self) -> bool:
        """Whether usual difference steps drown in the dither of the twin's encoder."""
        return any(step > DIFFERENCE_STEP for step in self.difference_steps.values())


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """Set of acting effects, beside the uncertain parameters.

    Attributes
    ----------
    setting : Setting
        Common to all hypotheses.
    effects : tuple of Candidate
        Effects that are on; their values are the start.
    """

    setting: Setting
    effects: tuple[Candidate, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Free parameters: the twin's, then `effect.parameter`."""
        own = tuple(u.name for u in self.setting.uncertain)
        return own + tuple(f"{c.effect}.{p.name}" for c in self.effects for p in c.parameters)

    @property
    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Lower and upper bounds, shape (n,)."""
        pairs = [(u.low, u.high) for u in self.setting.uncertain]
        for candidate in self.effects:
            limits = candidate.law.bounds(self.setting.excitation)
            pairs += [limits[p.name] for p in candidate.parameters]
        low, high = np.array(pairs, dtype=float).reshape(-1, 2).T
        return low, high

    @property
    def scales(self) -> NDArray[np.float64]:
        """Typical sizes, shape (n,)."""
        sizes = [u.scale for u in self.setting.uncertain]
        for candidate in self.effects:
            own = candidate.law.scales(self.setting.excitation)
            sizes += [own[p.name] for p in candidate.parameters]
        return np.array(sizes, dtype=float)

    @property
    def prior(self) -> NDArray[np.float64]:
        """Precision of a weak prior of each free parameter about any value, shape (n,)."""
        own = len(self.setting.uncertain)
        widths = self.scales * PRIOR_WIDTH
        widths[:own] = self.scales[:own] * _PARAMETER_WIDTH
        return widths**-2

    def magnitudes(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Size of each free parameter, or its typical one where that is larger, shape (n,)."""
        return np.maximum(np.abs(x), self.scales)

    def moved_by(self, steps: Mapping[str, float]) -> Hypothesis:
        """The same with other difference steps, as shares of the quantities' scales."""
        return replace(self, setting=replace(self.setting, difference_steps=steps))

    def difference_sizes(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Finite-difference step of each free parameter, shape (n,)."""
        low, high = self.bounds
        given = self.setting.difference_steps
        shares = np.array([given.get(name, DIFFERENCE_STEP) for name in self.names])
        sizes = np.minimum(shares * self.magnitudes(x), 0.3 * (high - low))
        signed: NDArray[np.float64] = np.where(x + sizes > high, -sizes, sizes)
        return signed

    def start(self, parameters: Mapping[str, float]) -> NDArray[np.float64]:
        """Vector of the effects' own values and these parameters of the twin."""
        values = [parameters.get(u.name, u.nominal) for u in self.setting.uncertain]
        for candidate in self.effects:
            values += [candidate.values[p.name] for p in candidate.parameters]
        return self.inside(np.array(values, dtype=float))

    def inside(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Move values strictly between their bounds."""
        low, high = self.bounds
        margin = _INSIDE * (high - low)
        clipped: NDArray[np.float64] = np.clip(x, low + margin, high - margin)
        return clipped

    def parameters(self, x: NDArray[np.float64]) -> dict[str, float]:
        """Uncertain parameters of the twin at a vector."""
        return {u.name: float(v) for u, v in zip(self.setting.uncertain, x, strict=False)}

    def at(self, x: NDArray[np.float64]) -> Hypothesis:
        """Return the same hypothesis with its effects' values taken from a vector."""
        place = len(self.setting.uncertain)
        effects = []
        for candidate in self.effects:
            names = [p.name for p in candidate.parameters]
            own = x[place : place + len(names)]
            effects.append(candidate.with_values(dict(zip(names, map(float, own), strict=True))))
            place += len(names)
        return replace(self, effects=tuple(effects))

    def point(self, x: NDArray[np.float64]) -> Point:
        """Values of the twin and of physics.fmu at a vector, shape (n,)."""
        parameters = self.parameters(x)
        physics: dict[str, float] = {}
        only: dict[str, int] = {}
        loads: dict[str, float] = {}
        for candidate in self.at(x).effects:
            law = candidate.law
            together = {**candidate.more, **candidate.values}
            physics |= law.variables(together, self.setting.excitation)
            if candidate.only is not None:
                only[candidate.effect] = candidate.only
            if law.inertia_share:
                loads[law.name] = candidate.values["load_inertia"]
        if loads and self.setting.inertia is not None:
            whole = parameters.get(self.setting.inertia)
            if whole is None:
                whole = self._nominal_inertia
            # Inertia behind the gap or shaft no longer turns with the twin's own.
            least = max(1e-3 * whole, self.setting.least_inertia)
            kept = max(whole - sum(loads.values()), least)
            parameters[self.setting.inertia] = kept
            physics |= {f"{name}.shaft_inertia": kept for name in loads}
        return Point(parameters, physics, only)

    @property
    def is_linear(self) -> bool:
        """Whether noise passes through the effects as small signals do."""
        return all(candidate.law.is_linear for candidate in self.effects)

    @property
    def bent(self) -> list[bool]:
        """Free parameters of effects that are not linear."""
        own = [False] * len(self.setting.uncertain)
        return own + [not c.law.is_linear for c in self.effects for _ in c.parameters]

    @property
    def acts_at_rest(self) -> bool:
        """Whether an effect pushes an axis that stands still."""
        return any(candidate.law.acts_at_rest for candidate in self.effects)

    @property
    def _nominal_inertia(self) -> float:
        inertia = self.setting.excitation.inertia
        assert inertia is not None, "effects that share the inertia are not tested without one"
        return inertia
