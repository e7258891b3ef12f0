"""Common parts of limits of the command."""

from __future__ import annotations

import numpy as np

from gmfbo.physics.excitation import Excitation
from gmfbo.physics.states import Array, Mask

# A limit must cut this share of the largest command before it is claimed.
CUT_SHARE = 5e-4

SHARES = (0.98, 0.75)
"""Of the largest demand, at which the fit of a limit starts."""

MORE_SHARES = (0.998, 0.99, 0.95, 0.85)
"""Of the largest demand: a limit that is met for milliseconds cuts a thousandth of it."""


def cut_floor(excitation: Excitation) -> float:
    """Smallest cut of the command that is claimed, in the unit of the command."""
    return CUT_SHARE * excitation.command


def clipped(command: Array, limit: Array | float) -> Array:
    """Change of a command by a limit: clip(u) - u, shape (n,)."""
    return np.asarray(np.clip(command, -limit, limit) - command, dtype=np.float64)


def beyond(command: Array, limit: Array | float) -> Mask:
    """Mark where the command is beyond a limit, shape (n,)."""
    return np.asarray(np.abs(command) > limit, dtype=np.bool_)
