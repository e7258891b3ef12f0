"""Cases with a measured port response, and residuals made of torques at that port."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gmfbo import FmuTwin
from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.case.open_case import open_case
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.runs.measured_excitation import states_of
from gmfbo.diagnosis.screening.port_response import PortResponse, measure_port_response
from gmfbo.diagnosis.screening.seen_from_port import whitened_columns
from gmfbo.physics import States
from gmfbo.recordings.recording import Recording
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.twin.augmented_twin import AugmentedTwin

SERVO = models_folder() / "servo_axis.toml"
GAINS = {"kp": 40.0, "kd": 0.8}
_TRUTH = {"inertia": 0.0105, "viscous": 0.03}


@dataclass(frozen=True, eq=False)
class PortCase:
    """An opened case and the response of its torque port."""

    case: Case
    response: PortResponse

    @property
    def states(self) -> list[States]:
        """Of each recording, as the fitted twin moves."""
        records = self.case.simulations.records
        return [states_of(run, r) for run, r in zip(self.case.base.simulated, records, strict=True)]

    def with_torque(self, torques: Sequence[NDArray[np.float64]], seed: int) -> Fitted:
        """Fitted twin whose residual is white but for torques that it lacks."""
        columns = [torque[None] for torque in torques]
        shown = whitened_columns(self.case.misfit, self.response, columns)
        rng = np.random.default_rng(seed)
        residual = tuple(block[0] + rng.standard_normal(block.shape[1]) for block in shown)
        return replace(self.case.base, residual=residual)

    def white(self, seed: int) -> Fitted:
        """Fitted twin that lacks nothing."""
        return self.with_torque([np.zeros(rows) for rows in self.response.rows], seed)


def port_case(case: Case) -> PortCase:
    """Measure the response of a case's torque port."""
    response = measure_port_response(case, "torque", np.random.default_rng(0))
    assert response is not None
    return PortCase(case, response)


def open_servo(physics: Mapping[str, float], twin: FmuTwin | None = None) -> Case:
    """Open the case of a servo axis that moves with hidden physics and a sensor's noise."""
    rng = np.random.default_rng(5)
    recordings = []
    with AugmentedTwin(FmuTwin(SERVO), substeps=10, isolated=False) as simulator:
        for k, (time, reference) in enumerate(_references()):
            asked = Recording(
                time=time, signals={"reference": reference}, name=f"rec{k}.csv", parameters=GAINS
            )
            added = {"sensor": 3e-5 * rng.standard_normal(time.size)}
            plan = simulator.plan(asked, _TRUTH)
            run = simulator.run(plan, _TRUTH, physics, excitation=added)
            command = run.held["torque_command"] + 0.02 * rng.standard_normal(time.size)
            signals = {"position": run.held["position"], "torque_command": command}
            recordings.append(
                replace(asked, signals={**asked.signals, **signals}, written_by="test")
            )
    return opened(twin or FmuTwin(SERVO), recordings)


def opened(twin: FmuTwin, recordings: Sequence[Recording]) -> Case:
    """Open the case of a twin and its recordings, with one simulator."""
    return open_case(twin, recordings, seed=0, jobs=1, on_run=lambda: None)


def _references() -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """A multisine, two moves and a triangle of two seconds each."""
    t: NDArray[np.float64] = 1e-3 * np.arange(2000, dtype=np.float64)
    tones = [(0.7, 0.1), (1.3, 2.0), (2.9, 4.2), (5.1, 5.5)]
    multisine = np.sum([0.15 * np.sin(2.0 * np.pi * f * t + p) for f, p in tones], axis=0)
    moves = np.clip((t - 0.2) * 4.0, 0.0, 1.0) - np.clip((t - 1.1) * 3.0, 0.0, 1.5)
    triangle = 0.5 * np.abs(((t * 0.8) % 2.0) - 1.0) - 0.5
    return [(t, multisine * np.minimum(1.0, t / 0.3)), (t, moves), (t, triangle)]
