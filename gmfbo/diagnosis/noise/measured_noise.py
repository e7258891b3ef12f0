"""Noise of the recorded signals, and its way through the loop."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.noise.loop_noise import noise_runs
from gmfbo.diagnosis.runs.quantum import resolution
from gmfbo.diagnosis.runs.scored_record import ScoredSignal
from gmfbo.diagnosis.runs.simulations import Simulations
from gmfbo.diagnosis.scoring.noise_levels import (
    NoiseLevel,
    fast_power,
    loop_covariance,
    noise_level,
    pooled,
)
from gmfbo.diagnosis.scoring.nuisances import Direction
from gmfbo.diagnosis.scoring.signal_parts import Rig
from gmfbo.diagnosis.scoring.whitening import Window
from gmfbo.sources.twin.twin import FmuTwin

Array = NDArray[np.float64]

_AS_MUCH = 0.7  # share of the noise above which its size is not reduced
_LEAST_SHARE = 1e-6
_SHOWN_HZ = (2.0, 100.0)  # band in which input noise can be told from output noise
_ABOVE_OWN = 4.0  # times the outputs' own noise
_FEWEST_BINS = 20


def noise_of_all(
    simulations: Simulations, rig: Rig, levels: Sequence[dict[str, NoiseLevel]]
) -> dict[str, NoiseLevel]:
    """Noise of each signal over all recordings, and of a recorded position in any case."""
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
    """Noise of the recorded position [FMU's unit]; None where no position is recorded."""
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
    windows: Sequence[Window],
    base: Fitted,
    rig: Rig,
    noise: Sequence[dict[str, NoiseLevel]],
    rng: np.random.Generator,
) -> list[list[Direction]]:
    """Changes of each recording's signals under noise of the recorded size.

    The fast part of a recorded input may be real, such as a loop's command, and no measurement
    noise. So no more of it is sent than the quietest recording shows.
    """
    counts = [
        s.resolution for r in simulations.records for s in r.signals if s.name == rig.position
    ]

    def runs(inputs: dict[str, list[float]]) -> list[list[Direction]]:
        return noise_runs(
            simulations,
            base.hypothesis.point(base.x),
            base.simulated,
            position_noise(simulations, rig, noise),
            rig.position,
            inputs,
            rng,
            float(np.median(counts)) / rig.position_to_si if counts else 0.0,
        )

    inputs = _input_noise(twin, simulations)
    through = runs(inputs)
    if not inputs:
        return through
    shares = np.sqrt(_shares_shown(simulations, windows, base, noise, through))
    shown = {port: float(np.min(shares * own)) for port, own in inputs.items()}
    if all(shown[port] > _AS_MUCH * max(own) for port, own in inputs.items()):
        return through
    # The sensor of an input is the same in all recordings.
    return runs({port: [level] * len(inputs[port]) for port, level in shown.items()})


def _shares_shown(
    simulations: Simulations,
    windows: Sequence[Window],
    base: Fitted,
    noise: Sequence[dict[str, NoiseLevel]],
    through: Sequence[Sequence[Direction]],
) -> Array:
    """Share of the noise's power that is in each recording's residual, at most 1."""
    ratios: dict[int, list[Array]] = {k: [] for k in range(len(simulations.records))}
    for window in windows:
        k = window.record
        signals = simulations.records[k].signals
        pairs = zip(signals, base.simulated[k].signals, strict=True)
        left = np.abs(window.spectra([s.values - values for s, values in pairs])) ** 2
        sent = np.real(np.einsum("fii->fi", loop_covariance(window, through[k])))
        white = window.white([noise[k][s.name].total ** 2 for s in signals])
        low, high = _SHOWN_HZ
        band = ((window.frequencies > low) & (window.frequencies < high))[:, None]
        told = band & window.seen & (sent > _ABOVE_OWN * white)
        ratios[k].append(left[told] / sent[told])
    shares = np.ones(len(ratios))
    for k, parts in ratios.items():
        if parts and (own := np.concatenate(parts)).size >= _FEWEST_BINS:
            shares[k] = np.median(own) / np.log(2.0)
    return np.asarray(np.clip(shares, _LEAST_SHARE, 1.0))


def _input_noise(twin: FmuTwin, simulations: Simulations) -> dict[str, list[float]]:
    """Noise [FMU's unit] of each recorded input that enters at a port, for each recording."""
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
