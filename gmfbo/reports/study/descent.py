"""Progress of the best real run of a study."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Descent:
    """Progress of the best real run; n real runs.

    Attributes
    ----------
    numbers : tuple of int
        Of the trials.
    cost : ndarray, shape (n,)
        [real runs] Cost of all runs up to that one.
    objective : ndarray, shape (n,)
        Cost g of the run, dimensionless.
    best : ndarray, shape (n,)
        Least cost so far; NaN before the first run that succeeded.
    """

    numbers: tuple[int, ...]
    cost: Array
    objective: Array
    best: Array
