"""Rank runs before their cost counts: settled, bounded but not settled, failed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gmfbo.objective.settled import short_of_settling
from gmfbo.tuning.history.state import Observation


def by_rank(observations: Sequence[Observation]) -> tuple[Observation, ...]:
    """Mark the observations whose cost is modelled: those of the best rank of a real run.

    Once a real run has settled, settled runs alone have a cost. While none has, what is sought is
    a run that settles: then all bounded runs count, and their cost is how far they are from
    settling. Failed runs never have a cost.

    Parameters
    ----------
    observations : sequence of Observation
        Of all sources.
    """
    real = [seen for seen in observations if seen.source == "IS1"]
    if not real or any(seen.settled for seen in real):
        return tuple(replace(seen, counts=seen.settled) for seen in observations)
    return tuple(
        replace(seen, counts=False)
        if seen.failed
        else replace(seen, objective=float(short_of_settling(np.array(seen.late_error))))
        for seen in observations
    )
