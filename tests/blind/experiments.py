"""Which recordings are made of a machine, and what they show of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from tests.blind.hidden import Rng, Setting
from tests.blind.machines import Machine
from tests.blind.oracle import Experiment
from tests.blind.references import SHAPES, one_way_moves
from tests.blind.truth import TrueRun, Vector, simulate


def experiments_of(
    machine: Machine, true: Mapping[str, float], rng: Rng, one_way: bool = False
) -> list[Experiment]:
    """Four to six recordings; a third of them at other gains.

    Parameters
    ----------
    machine : Machine
        For its strokes.
    true : mapping of str to float
        The plant without effects.
    rng : Generator
        Decides on shapes, gains and lengths.
    one_way : bool
        Never turn back.
    """
    shapes = ["multisine", "moves", "triangle", "chirp" if rng.random() < 0.6 else "steps"]
    shapes += [str(shape) for shape in rng.permutation(["steps", "moves"])][
        : int(rng.choice([0, 1, 2], p=[0.7, 0.2, 0.1]))
    ]
    experiments = []
    for shape in ["moves"] * 4 if one_way else shapes:
        gains = {
            own: float(
                f"{true[own] * (rng.uniform(0.75, 1.25) if rng.random() < 0.33 else 1.0):.4g}"
            )
            for own in machine.gains
        }
        rows = int(rng.integers(2500, 4001))
        wave = one_way_moves(rng, rows) if one_way else SHAPES[shape](rng, rows)
        reference = wave * machine.strokes[shape] * rng.uniform(0.8, 1.2)
        experiments.append(Experiment(shape, _within_limit(reference, {**true, **gains}), gains))
    return experiments


def _within_limit(reference: Vector, values: Mapping[str, float]) -> Vector:
    """The reference, reduced until its command stays within three quarters of the limit."""
    while np.max(np.abs(simulate(values, reference).new)) > 0.75 * values["u_limit"]:
        reference = 0.8 * reference
    return reference


def setting_of(machine: Machine, true: Mapping[str, float], runs: Sequence[TrueRun]) -> Setting:
    """What an effect is put into, from runs without it."""
    commands = [run.new for run in runs]
    peak_command = float(max(np.max(np.abs(u)) for u in commands))
    peak_speed = float(max(np.max(np.abs(run.velocity)) for run in runs))
    return Setting(
        machine=machine,
        values=true,
        peak_command=peak_command,
        rms_command=float(np.sqrt(np.mean(np.concatenate(commands) ** 2))),
        peak_slew=float(max(np.max(np.abs(np.diff(u))) for u in commands) / 1e-3),
        peak_speed=peak_speed,
        travel=float(max(np.max(np.abs(run.position)) for run in runs)),
        peak_mix=float(
            max(np.max(np.abs(run.new / peak_command + run.velocity / peak_speed)) for run in runs)
        ),
    )
