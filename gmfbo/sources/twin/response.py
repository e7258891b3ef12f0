"""What an augmented twin answers to a recording."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.sources.fmu_file.job import Outcome

Columns = Mapping[str, NDArray[np.float64]]


@dataclass(frozen=True, eq=False)
class Response:
    """Response of an augmented twin to a recording, on the communication grid.

    Attributes
    ----------
    outcome : Outcome
        How the run ended; columns hold NaN after its end.
    held : mapping of str to ndarray, shape (rows,)
        [SI] Signals of [outputs] at t_k, before the inputs of t_k act.
    new : mapping of str to ndarray, shape (rows,)
        [SI] Signals of [outputs] right after the inputs of t_k have acted.
    mean : mapping of str to ndarray, shape (rows,)
        [SI] Signals of [outputs], averaged over the fine steps since t_(k-1).
    states : mapping of str to ndarray, shape (rows,)
        [FMU's units] Of [states].
    ports : mapping of str to ndarray, shape (rows,)
        [FMU's units] Signal that physics adds at each port from t_k on.
    effort : ndarray, shape (rows,)
        [unit of the torque port] Of the tracking loop.
    """

    outcome: Outcome
    held: Columns
    new: Columns
    mean: Columns
    states: Columns
    ports: Columns
    effort: NDArray[np.float64]
