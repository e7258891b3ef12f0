"""The next experiment that a diagnosis asks for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class NextExperiment:
    """A reference to play next, and each rival's prediction of the outcome.

    Attributes
    ----------
    reference : str
        File that a drive can play; empty where none would tell more.
    separates : tuple of str
        Effects that it tells apart.
    distance : float
        [nats] Least expected log odds of the true one against another of these, refitted; the
        largest where none are told apart.
    threshold : float
        [nats] Log odds from which they are told apart.
    predicted : mapping of str to str
        Predicted observation by rival, in plain words.
    why : str
        Purpose of the experiment.
    """

    reference: str
    separates: tuple[str, ...]
    distance: float
    threshold: float
    predicted: Mapping[str, str]
    why: str
