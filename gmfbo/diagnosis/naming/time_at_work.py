"""For how long an effect is at work in recordings."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.diagnosis.runs.measured_excitation import states_of
from gmfbo.diagnosis.runs.scored_record import Record
from gmfbo.diagnosis.runs.simulated import Simulated


def seconds_at_work(
    effect: Candidate, simulated: Sequence[Simulated], records: Sequence[Record]
) -> float:
    """Time [s] in which an effect shows, over all recordings."""
    total = 0.0
    values = {**effect.more, **effect.values}
    for run, record in zip(simulated, records, strict=True):
        states = states_of(run, record)
        total += states.step * float(np.count_nonzero(effect.law.acts(states, values)))
    return total
