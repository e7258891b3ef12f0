"""Result of testing a residual against the reference."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ResidualTest:
    """Part of one signal's error that follows the reference in one held-out recording.

    All are RMS over the range of the recorded signal, dimensionless.

    Attributes
    ----------
    recording : str
        Its name.
    signal : str
        Its name.
    before : float
        Part of the refitted twin's error that follows the reference.
    follows : float
        Part of the final model's error that follows the reference.
    bound : float
        Exceeded by chance once in a hundred times, with noise like that of the final model, beside
        what its simulation's step changes.
    tolerance : float
        Small errors that every rig has, which the diagnosis ignores.
    """

    recording: str
    signal: str
    before: float
    follows: float
    bound: float
    tolerance: float
