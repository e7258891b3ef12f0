"""Explanations of a diagnosis as values, by which it predicts new recordings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from gmfbo.plain_words import words

PARAMETERS_ONLY = "parameters"
"""Name of the explanation without physics: the refitted twin."""


def said(name: str) -> str:
    """Name of an explanation in words."""
    return "the refitted twin alone" if name == PARAMETERS_ONLY else words(name)


@dataclass(frozen=True)
class Explanation:
    """One explanation of the recordings, with its fitted values.

    Attributes
    ----------
    name : str
        Its effects, joined by " + "; `parameters` where it has none.
    effects : tuple of str
        Names in the catalogue.
    parameters : mapping of str to float
        [FMU's unit] The twin's uncertain parameters.
    physics : mapping of str to float
        Of physics.fmu, such as `coulomb_friction.level`; effects of one recording only are absent.
    misfit : float
        chi2 per whitened residual on the recordings that it was fitted to, dimensionless.
    """

    name: str
    effects: tuple[str, ...]
    parameters: Mapping[str, float]
    physics: Mapping[str, float]
    misfit: float


@dataclass(frozen=True)
class Span:
    """Range of one state that the recordings cover.

    Attributes
    ----------
    low, high : float
        [unit]
    unit : str
        As the twin's FMU spells it.
    """

    low: float
    high: float
    unit: str


@dataclass(frozen=True)
class Predictions:
    """Remaining explanations, with the values needed to simulate and judge them.

    Attributes
    ----------
    explanations : tuple of Explanation
        The named effects, their rivals, and the refitted twin alone.
    threshold : float
        Difference in chi2 above which two explanations are told apart.
    noise : mapping of str to float
        [SI] Standard deviation of each signal's noise.
    spans : mapping of str to Span
        Ranges of position, velocity, command, current, load and torque.
    new_rows : tuple of str
        Signals of which the logger stores the value just computed.
    straight : tuple of str
        Inputs that were driven straight from row to row.
    """

    explanations: tuple[Explanation, ...]
    threshold: float
    noise: Mapping[str, float]
    spans: Mapping[str, Span]
    new_rows: tuple[str, ...]
    straight: tuple[str, ...] = ()
