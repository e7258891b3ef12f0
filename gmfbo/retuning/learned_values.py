"""What an estimate says of the twin's parameters and tables, for the log of a version."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.stats import norm

from gmfbo.retuning.believed_values import precision_of
from gmfbo.retuning.calibration import Estimate
from gmfbo.retuning.unknowns import Unknowns

SYSTEMATIC = 1
"""Independent samples by which a signal of a run counts in an interval. What a calibrated twin
still misses is systematic: it is shared by all samples of a run. Counted as in the estimation,
the interval of the drive's inertia missed the truth on five of five seeds with a wrong table;
counted once, 8 of 10 intervals of the same runs hold it."""

_SIDE = float(norm.ppf(0.975))
"""Standard deviations to each end of a 95 % interval."""


def learned_values(
    unknowns: Unknowns, estimate: Estimate, units: Mapping[str, str], given: int
) -> dict[str, list[dict[str, Any]]]:
    """Parameters with value before, value now and 95 % interval, and the change of each table.

    The interval is that of the normal approximation about the estimate, within the stated range,
    with the twin's error taken as systematic.

    Parameters
    ----------
    unknowns : Unknowns
        Estimated parameters and tables.
    estimate : Estimate
        With the slopes of its runs.
    units : mapping of str to str
        Unit of each FMU parameter, as the FMU spells it.
    given : int
        Number of scalars that the twin as given has; later ones are parameters of added physics.
    """
    # So is what it misses at gains like these: all runs together count as one.
    shared = SYSTEMATIC / max(len(estimate.slopes), 1)
    covariance = np.linalg.inv(precision_of(unknowns, estimate, shared))
    reach = _SIDE * np.sqrt(np.diag(covariance))
    learned = [
        {
            "name": one.name,
            "unit": units.get(one.name, ""),
            "before": one.nominal if place < given else None,
            "after": one.value(estimate.x[place]),
            "low": one.value(estimate.x[place] - reach[place]),
            "high": one.value(estimate.x[place] + reach[place]),
        }
        for place, one in enumerate(unknowns.scalars)
    ]
    changes = zip(unknowns.tables, unknowns.priors, unknowns.changes(estimate.x), strict=True)
    tables = [
        {"name": table.name, "change": float(np.sqrt(np.mean(change**2))) / prior.scale}
        for table, prior, change in changes
    ]
    return {"learned": learned, "tables": tables}
