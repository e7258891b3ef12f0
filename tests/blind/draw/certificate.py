"""Shows that the plant in MuJoCo and the twin are the same where their parameters are."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gmfbo import FmuTwin, Recording
from tests.blind.draw.mujoco_axis import simulate_in_mujoco
from tests.blind.machines import Knowledge, Machine, twin_file
from tests.blind.oracle import Experiment
from tests.blind.truth import SAMPLE, Vector

MOST = 0.25
"""Of a column's own white noise: the largest difference at any row."""

COARSEST, HALVINGS = 2e-4, 5
"""[s] First step that is tried, and how often it may be halved."""


@dataclass(frozen=True)
class Certificate:
    """Largest differences of MuJoCo and twin, over the noise of each column.

    Attributes
    ----------
    step : float
        [s] Of MuJoCo, as the case uses it.
    integrator : str
        As MuJoCo names it.
    at_step, at_half_step : dict of str to float
        Largest difference of any row of any recording, as a share of the noise, by column.
    """

    step: float
    integrator: str
    at_step: Mapping[str, float]
    at_half_step: Mapping[str, float]

    @property
    def holds(self) -> bool:
        """Both are below a quarter of the noise."""
        return all(share < MOST for d in (self.at_step, self.at_half_step) for share in d.values())

    def told(self) -> dict[str, Any]:
        """As plain data, for the answer."""
        return asdict(self)


def certify(
    machine: Machine,
    values: Mapping[str, float],
    experiments: Sequence[Experiment],
    integrator: str,
) -> Certificate:
    """Find the coarsest step of MuJoCo at which a case is certified.

    Parameters
    ----------
    machine : Machine
        A servo.
    values : mapping of str to float
        The true plant: the twin gets the same values here.
    experiments : sequence of Experiment
        The references of the case; all of them count.
    integrator : str
        MuJoCo's.

    Raises
    ------
    RuntimeError
        No step is fine enough.
    """
    twin_runs = _in_the_twin(machine, values, experiments)

    def worst(step: float) -> dict[str, float]:
        return _differences(machine, values, experiments, twin_runs, step, integrator)

    step, at_step = COARSEST, worst(COARSEST)
    for _ in range(HALVINGS):
        at_half = worst(0.5 * step)
        certificate = Certificate(step, integrator, at_step, at_half)
        if certificate.holds:
            return certificate
        step, at_step = 0.5 * step, at_half
    raise RuntimeError(
        f"MuJoCo's {integrator} differs from the twin by {at_step} of the noise at a step of "
        f"{step:g} s: expected less than {MOST}"
    )


def _in_the_twin(
    machine: Machine, values: Mapping[str, float], experiments: Sequence[Experiment]
) -> list[tuple[Vector, Vector]]:
    """Position and command of the FMU at the true values, without noise."""
    runs = []
    with tempfile.TemporaryDirectory() as folder:
        for one in experiments:
            path = Path(folder) / "twin.toml"
            known = Knowledge({k: float(v) for k, v in {**values, **one.gains}.items()})
            path.write_text(twin_file(machine, known, path.parent), encoding="utf-8")
            time = np.asarray(np.arange(len(one.reference)) * SAMPLE, dtype=float)
            with FmuTwin(path) as twin:
                run = twin.run({}, Recording(time, {"reference": one.reference}))
            runs.append((run.signal("position"), run.signal(machine.command_name)))
    return runs


def _differences(
    machine: Machine,
    values: Mapping[str, float],
    experiments: Sequence[Experiment],
    twin_runs: Sequence[tuple[Vector, Vector]],
    step: float,
    integrator: str,
) -> dict[str, float]:
    noise = {
        "position": float(np.hypot(machine.jitter, machine.quantum / np.sqrt(12.0))),
        "command": machine.command_noise,
    }
    worst = dict.fromkeys(noise, 0.0)
    for one, (position, command) in zip(experiments, twin_runs, strict=True):
        played = {**values, **one.gains}
        run = simulate_in_mujoco(played, one.reference, preroll=1, step=step, integrator=integrator)
        apart = {"position": run.position - position, "command": run.held - command}
        for name, difference in apart.items():
            worst[name] = max(worst[name], float(np.max(np.abs(difference))) / noise[name])
    return {name: float(f"{share:.3g}") for name, share in worst.items()}
