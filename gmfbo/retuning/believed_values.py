"""Draw values of a twin's unknowns from what the real runs leave uncertain."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky, solve_triangular

from gmfbo.retuning.calibration import EFFECTIVE_SAMPLES, Estimate
from gmfbo.retuning.unknowns import Unknowns


def drawn_values(
    unknowns: Unknowns, estimate: Estimate, rng: np.random.Generator
) -> dict[str, float]:
    """FMU parameters drawn from the normal approximation about an estimate.

    Parameters
    ----------
    unknowns : Unknowns
        Estimated parameters and tables.
    estimate : Estimate
        With the slopes of its runs.
    rng : numpy.random.Generator
        Source of randomness.

    Returns
    -------
    dict of str to float
        By FMU parameter [FMU's unit].
    """
    factor = cholesky(precision_of(unknowns, estimate), lower=True)
    step = solve_triangular(factor.T, rng.standard_normal(estimate.x.size), lower=False)
    return unknowns.settings(estimate.x + step)


def precision_of(
    unknowns: Unknowns, estimate: Estimate, samples: float = EFFECTIVE_SAMPLES
) -> NDArray[np.float64]:
    """Precision of x about an estimate, shape (size, size).

    It is that of the prior plus what each run says by its slopes (Gauss-Newton).

    Parameters
    ----------
    unknowns : Unknowns
        Estimated parameters and tables.
    estimate : Estimate
        With the slopes of its runs.
    samples : float
        Independent samples by which a signal of a run counts.
    """
    prior = unknowns.prior_slope(estimate.x)
    precision = prior.T @ prior
    for slope in estimate.slopes.values():
        count = len(slope) // len(estimate.errors)
        share = np.sqrt(min(samples / count, 1.0))
        weighed = slope * np.repeat(share / estimate.errors, count)[:, None]
        precision = precision + weighed.T @ weighed
    return np.asarray(precision + 1e-9 * np.eye(estimate.x.size))
