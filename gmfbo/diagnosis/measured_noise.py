"""Noise of the recorded signals, and what the loop makes of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gmfbo.diagnosis.budget import NoiseLevel, fast_power, noise_level, pooled
from gmfbo.diagnosis.fitting import Fitted
from gmfbo.diagnosis.loop_noise import noise_runs
from gmfbo.diagnosis.nuisances import Direction
from gmfbo.diagnosis.records import ScoredSignal, resolution
from gmfbo.diagnosis.rig import Rig
from gmfbo.diagnosis.simulations import Simulations
from gmfbo.sources.twin import FmuTwin


def noise_of_all(
    simulations: Simulations, rig: Rig, levels: Sequence[dict[str, NoiseLevel]]
) -> dict[str, NoiseLevel]:
    """Noise of each signal over all recordings, that of the position in any case.

    Parameters
    ----------
    simulations : Simulations
        Of the recordings.
    rig : Rig
        Which signal is the position.
    levels : sequence of mapping of str to NoiseLevel
        Of each recording.
    """
    names = dict.fromkeys(name for level in levels for name in level)
    found = {name: level for name in names if (level := pooled(list(levels), name)) is not None}
    if rig.position is not None and rig.position not in found:
        own = position_noise(simulations, rig, levels) or 0.0
        total = own * rig.position_to_si
        found[rig.position] = NoiseLevel(total, total)
    return found


def position_noise(
    simulations: Simulations, rig: Rig, noise: Sequence[dict[str, NoiseLevel]]
) -> float | None:
    """Noise of the recorded position [FMU's unit]; None where there is none.

    Parameters
    ----------
    simulations : Simulations
        Of the recordings.
    rig : Rig
        Which signal is the position.
    noise : sequence of mapping of str to NoiseLevel
        Of each recording.
    """
    if rig.position is None:
        return None
    level = pooled(list(noise), rig.position)
    if level is not None:
        return level.total / rig.position_to_si
    found = []
    for record in simulations.records:
        column = record.plan.recording.signal(rig.position)
        values = column[np.isfinite(column)]
        rows = np.arange(values.size, dtype=np.float64)
        signal = ScoredSignal(rig.position, rows, values, resolution(values))
        found.append(noise_level(signal, values).total)
    return float(np.median(found)) / rig.position_to_si


def noise_through_loop(
    twin: FmuTwin,
    simulations: Simulations,
    base: Fitted,
    rig: Rig,
    noise: Sequence[dict[str, NoiseLevel]],
    rng: np.random.Generator,
) -> list[list[Direction]]:
    """Changes of each recording's signals under noise as large as the one that was recorded.

    Parameters
    ----------
    twin : FmuTwin
        The user's.
    simulations : Simulations
        Of the recordings.
    base : Fitted
        About which.
    rig : Rig
        Which signal is the position.
    noise : sequence of mapping of str to NoiseLevel
        Of each recording.
    rng : numpy Generator
        Source of the noise.
    """
    counts = [
        s.resolution for r in simulations.records for s in r.signals if s.name == rig.position
    ]
    return noise_runs(
        simulations,
        base.hypothesis.point(base.x),
        base.simulated,
        position_noise(simulations, rig, noise),
        rig.position,
        _input_noise(twin, simulations),
        rng,
        float(np.median(counts)) / rig.position_to_si if counts else 0.0,
    )


def _input_noise(twin: FmuTwin, simulations: Simulations) -> dict[str, list[float]]:
    """[FMU's unit] Of each recorded input that enters at a port, for each recording."""
    file, variables = twin.file, twin.binding.variables
    found: dict[str, list[float]] = {}
    for port, variable in file.ports.items():
        for name, entry in file.inputs.items():
            if entry.variable != variable:
                continue
            factor = variables[variable].variable.to_si
            found[port] = [
                float(np.sqrt(fast_power(record.plan.experiment.inputs[name]))) / factor
                for record in simulations.records
                if name in record.plan.experiment.inputs
            ]
    return {p: levels for p, levels in found.items() if len(levels) == len(simulations.records)}
