"""What was decided about missing effects, and the evidence that it rests on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.diagnosis.fitting.misfit import Misfit
from gmfbo.diagnosis.screening.probes import Probe, Screened


@dataclass(frozen=True, eq=False)
class Evidence:
    """An effect that was fitted, and what it gains on what the fit has not seen.

    Attributes
    ----------
    fitted : Fitted
        The model with the effect as its last.
    gains : ndarray, shape (n_groups,)
        Fall of chi2 in each group that was left out.
    signature : ndarray, shape (n_groups,)
        Square of the change that the effect makes in each group.
    chi2 : float
        Of the fit to all.
    """

    fitted: Fitted
    gains: NDArray[np.float64]
    signature: NDArray[np.float64]
    chi2: float

    @property
    def effect(self) -> Candidate:
        """The effect, at its fitted values."""
        return self.fitted.hypothesis.effects[-1]

    @property
    def name(self) -> str:
        """Its name in the catalogue."""
        return self.effect.effect

    @property
    def gain(self) -> float:
        """Fall of chi2 on what was left out, over all groups."""
        return float(self.gains.sum())

    def measured_by(self, misfit: Misfit) -> Evidence:
        """Return the same with its fit measured by another budget; its gain stays."""
        fitted = self.fitted.measured_by(misfit)
        return replace(self, fitted=fitted, chi2=fitted.chi2)


@dataclass(frozen=True, eq=False)
class Round:
    """One effect accepted, and what competed with it.

    Attributes
    ----------
    winner : Evidence
        What was accepted.
    rivals : tuple of Evidence
        Effects that explain the recordings as well.
    fitted : tuple of Evidence
        All effects that were fitted in this round.
    needed : float
        Gain that was asked for.
    margin : float
        Gain that a law has to have over its limit.
    """

    winner: Evidence
    rivals: tuple[Evidence, ...]
    fitted: tuple[Evidence, ...]
    needed: float
    margin: float

    def measured_by(self, misfit: Misfit) -> Round:
        """Return the same with all fits measured by another budget."""
        return replace(
            self,
            winner=self.winner.measured_by(misfit),
            rivals=tuple(entry.measured_by(misfit) for entry in self.rivals),
            fitted=tuple(entry.measured_by(misfit) for entry in self.fitted),
        )


def model_after(rounds: Sequence[Round], base: Fitted) -> Fitted:
    """The twin with what was accepted in some rounds.

    Parameters
    ----------
    rounds : sequence of Round
        In the order of their discovery.
    base : Fitted
        The twin without effects.
    """
    return rounds[-1].winner.fitted if rounds else base


@dataclass(frozen=True, eq=False)
class Beside:
    """A first effect judged again, beside what was found after it.

    Alone, what is missing beside it speaks against it.

    Attributes
    ----------
    without : Fitted
        The twin with all effects but this one.
    entry : Round
        The effect, and the laws of its family that were fitted in its place.
    """

    without: Fitted
    entry: Round

    def measured_by(self, misfit: Misfit) -> Beside:
        """Return the same with all fits measured by another budget."""
        return Beside(self.without.measured_by(misfit), self.entry.measured_by(misfit))


@dataclass(eq=False)
class Decision:
    """What was accepted, in the order of its discovery.

    Attributes
    ----------
    rounds : list of Round
        One for each accepted effect.
    model : Fitted
        The twin with all accepted effects.
    tried : list of Probe
        The whole library and its grids.
    like_parameters : dict of str to str
        Effects that were left out, and why: mostly a parameter of the twin does the same.
    screened : list of Screened
        What each probe explains of what the parameters leave.
    threshold : float
        Gain that chance gives once in a hundred times.
    groups : tuple of int
        Group of each window; whole groups are left out together.
    refused : list of Evidence
        Effects of the last round, of which none was accepted.
    dispersion : float
        chi2 per degree of freedom that the best model left by the budget alone, at least 1.
    left : float
        The same as it was: below 1 where the budget of noise is generous.
    silent : frozenset of str
        Effects that were not excited and cannot be named.
    in_doubt : Evidence or None
        One of them that explains as much as the best that could have been named.
    too_small : Evidence or None
        An effect below its floor that explains more than any that could have been named.
    unsettled : Evidence or None
        What passed in the first moments and explains more than any that could have been named.
    disputed : Evidence or None
        An effect against which some recordings speak, and which yet gains far more than any that
        could have been named: something acts that is like it, and is not it.
    beside_rest : Beside or None
        The first effect and its family, judged beside what was found after it.
    contradicted : bool
        Names that were beyond doubt in the fitted recordings failed on the held-out ones.
    """

    rounds: list[Round] = field(default_factory=list)
    model: Fitted | None = None
    tried: list[Probe] = field(default_factory=list)
    like_parameters: dict[str, str] = field(default_factory=dict)
    screened: list[Screened] = field(default_factory=list)
    threshold: float = np.inf
    groups: tuple[int, ...] = ()
    refused: list[Evidence] = field(default_factory=list)
    dispersion: float = 1.0
    left: float = np.inf
    silent: frozenset[str] = frozenset()
    in_doubt: Evidence | None = None
    too_small: Evidence | None = None
    unsettled: Evidence | None = None
    disputed: Evidence | None = None
    beside_rest: Beside | None = None
    contradicted: bool = False
