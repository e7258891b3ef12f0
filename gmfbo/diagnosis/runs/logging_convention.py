"""Logging convention: what a recorded command and a recorded position hold at t_k."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.runs.simulated import Point, Simulated
from gmfbo.diagnosis.runs.simulations import Simulations
from gmfbo.diagnosis.runs.twin_steps import READ_BACK
from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin.twin import FmuTwin

_JUMP_SHARE = 0.7  # least share of a command's squared changes that falls on sampling instants


def logged_new(
    twin: FmuTwin,
    recordings: Sequence[Recording],
    simulations: Simulations,
    nominal: Sequence[Simulated],
) -> frozenset[str]:
    """Outputs whose logger stores the value just computed instead of the held one.

    Parameters
    ----------
    twin : FmuTwin
        The user's twin, whose file may state the convention.
    recordings : sequence of Recording
        Recordings of the axis.
    simulations : Simulations
        Of these recordings.
    nominal : sequence of Simulated
        The recordings simulated.
    """
    chosen = set()
    for name, entry in twin.file.outputs.items():
        if entry.logged == "new" or (
            entry.logged == "unknown"
            and not all(recording.written_by for recording in recordings)
            and _new_fits_better(simulations, nominal, name)
        ):
            chosen.add(name)
    return frozenset(chosen)


def _new_fits_better(simulations: Simulations, nominal: Sequence[Simulated], name: str) -> bool:
    """Compare the fast parts, which show a shift of one sample and hardly any parameter."""
    squares = {"held": 0.0, "new": 0.0}
    for k, (record, run) in enumerate(zip(simulations.records, nominal, strict=True)):
        for i, signal in enumerate(record.signals):
            if signal.name != name:
                continue
            held = simulations.read(run.response, k)[i]
            new = simulations.read(replace(run.response, held=run.response.new), k)[i]
            if not _jumps(held, new):
                return False  # a measurement moves continuously: it is not held
            for key, values in (("held", held), ("new", new)):
                squares[key] += float(np.sum(np.diff(signal.values - values) ** 2))
    return squares["new"] < squares["held"]


def _jumps(held: NDArray[np.float64], new: NDArray[np.float64]) -> bool:
    """Whether a signal changes at communication points only, as commands do."""
    whole, at_point = float(np.sum(np.diff(held) ** 2)), float(np.sum((new - held) ** 2))
    return at_point > _JUMP_SHARE * whole > 0.0


def shows_late(simulations: Simulations, position: str, to_si: float) -> bool:
    """Whether a recorded position holds the sensor port's signal of the step before.

    Parameters
    ----------
    simulations : Simulations
        Of the recordings.
    position : str
        The output.
    to_si : float
        [SI / FMU's unit] Of the position.
    """
    plain = simulations.run_one(Point(), 0)
    column = plain.response.held[position]
    if "sensor" not in plain.response.ports or column.size < 3:
        return False
    size = max(1e-3 * float(np.ptp(column)) / to_si, 1e-6)
    push = np.full(simulations.records[0].plan.grid.size, size)
    push[:2] = 0.0  # the first row is held before the recording begins
    moved = simulations.run_one(Point(), 0, excitation={"sensor": push}).response.held[position]
    seen = np.abs(moved - column)[1:4] > READ_BACK * size * to_si
    # What is pushed from the third row on shows there at once, or a row later.
    return bool(seen.size == 3 and not seen[1] and seen[2])
