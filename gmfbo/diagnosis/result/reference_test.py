"""What a test of a residual against the reference came to."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ResidualTest:
    """How much of one signal's error follows the reference in one held-out recording.

    All are RMS over the range of the recorded signal, dimensionless.

    Attributes
    ----------
    recording : str
        Which one.
    signal : str
        Which one.
    before : float
        Of what the twin with refitted parameters leaves.
    follows : float
        Of what the final model leaves.
    bound : float
        What chance gives once in a hundred times, with noise like that of the final model.
    tolerance : float
        What the diagnosis does not look at: small errors that every rig has.
    """

    recording: str
    signal: str
    before: float
    follows: float
    bound: float
    tolerance: float
