"""Short recordings of any twin with physics that it lacks, for small runs of the diagnosis."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gmfbo import FmuTwin, diagnose
from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.case.open_case import open_case
from gmfbo.diagnosis.diagnosis import Diagnosis
from gmfbo.diagnosis.naming.decided_by_score import decide
from gmfbo.diagnosis.naming.decision import Decision
from gmfbo.diagnosis.screening.testable_effects import untestable
from gmfbo.physics import CATALOGUE
from gmfbo.recordings.recording import Recording
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.twin.augmented_twin import AugmentedTwin, RunPlan

Reference = Callable[[NDArray[np.float64]], NDArray[np.float64]]

PLANT = ("coulomb_friction", "viscous_friction", "constant_torque_offset", "gravity_torque")
LOOP = (*PLANT, "actuator_gain_loss", "transport_delay", "sensor_lag")
"""Effects of the plant, and of all ports of a loop."""

SERVO_GAINS = {"kp": 40.0, "kd": 0.8}
SERVO_NOISE = {"position": 3e-5, "torque_command": 0.02}
SERVO_TRUTH = {"inertia": 0.0105, "viscous": 0.03}


def multisine(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """Four tones up to 5 Hz that set in within 0.2 s."""
    tones = [(0.9, 0.15, 0.1), (1.7, 0.12, 2.0), (2.9, 0.1, 4.2), (5.1, 0.06, 5.5)]
    total = np.sum([a * np.sin(2.0 * np.pi * f * t + p) for f, a, p in tones], axis=0)
    rising: NDArray[np.float64] = total * np.minimum(1.0, t / 0.2)
    return rising


def moves(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """Move there, rest, and move back beyond the start."""
    return np.clip((t - 0.1) * 4.0, 0.0, 0.8) - np.clip((t - 0.7) * 4.0, 0.0, 1.2)


def triangle(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """Slow sweeps to and fro at one speed."""
    swept: NDArray[np.float64] = 0.4 * np.abs(((t * 1.2) % 2.0) - 1.0) - 0.4
    return swept


def climb(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """Only ever forward."""
    return 0.5 * t + 0.05 * (1.0 - np.cos(2.0 * np.pi * t)) / (2.0 * np.pi)


@dataclass(frozen=True)
class Axis:
    """A twin file, and how its real axis is made.

    Attributes
    ----------
    model : str
        Twin file in the models' folder, without its ending.
    driven : str
        Input that follows a reference.
    truth : mapping of str to float
        Parameters of the real axis where they differ from the twin's.
    gains : mapping of str to float
        Parameters that a recording states.
    noise : mapping of str to float
        [SI] White noise of each recorded signal; that of the position goes through the loop where
        the twin has a sensor port.
    """

    model: str = "servo_axis"
    driven: str = "reference"
    truth: Mapping[str, float] = field(default_factory=lambda: SERVO_TRUTH)
    gains: Mapping[str, float] = field(default_factory=lambda: SERVO_GAINS)
    noise: Mapping[str, float] = field(default_factory=lambda: SERVO_NOISE)

    def twin(self) -> FmuTwin:
        """Open the twin."""
        return FmuTwin(models_folder() / f"{self.model}.toml")

    def recordings(
        self,
        physics: Mapping[str, float],
        references: Sequence[Reference] = (multisine, moves),
        *,
        seconds: float = 1.4,
        seed: int = 5,
        signals: Sequence[str] | None = None,
        logged_new: Sequence[str] = (),
        written_by: str = "test",
        twin: FmuTwin | None = None,
        held: float = 0.0,
    ) -> list[Recording]:
        """Simulate the real axis along each reference.

        Parameters
        ----------
        physics : mapping of str to float
            Of physics.fmu, at the ports.
        references : sequence of callable
            Reference over time; what the driven input gets.
        seconds : float
            [s] Of each recording, at 1 kHz.
        seed : int
            Of the noise.
        signals : sequence of str, optional
            Outputs that are recorded; all unless given.
        logged_new : sequence of str
            Outputs of which the logger stores the value after the inputs have acted.
        written_by : str
            What wrote the file; empty where the logger's convention is not known.
        twin : FmuTwin, optional
            In place of the model's own.
        held : float
            [s] For which the first reference was held before the recording began.
        """
        rng = np.random.default_rng(seed)
        time = np.arange(round(seconds * 1000), dtype=np.float64) * 1e-3
        made = []
        # In this process: a worker takes ten times as long to start as these runs take.
        with AugmentedTwin(twin or self.twin(), substeps=10, isolated=False) as simulator:
            for k, reference in enumerate(references):
                asked = Recording(
                    time=time,
                    signals={self.driven: reference(time)},
                    name=f"rec{k}.csv",
                    parameters=self.gains,
                    written_by=written_by,
                )
                plan = simulator.plan(asked, self.truth)
                if held:
                    rows = round(held / simulator.twin.step)
                    plan = RunPlan.after(asked, plan.experiment, rows, plan.substeps)
                noise = {
                    name: sigma * rng.standard_normal(time.size)
                    for name, sigma in self.noise.items()
                }
                through = None
                if "sensor" in simulator.ports and "position" in noise:
                    through = {"sensor": noise["position"]}
                    noise["position"] = np.zeros(time.size)
                run = simulator.run(plan, self.truth, physics, excitation=through)
                assert run.outcome.status == "ok", run.outcome.message
                columns = {
                    # The reading at t_k holds the noise of t_k, which the controller sees too.
                    name: run.states["position"] + through["sensor"]
                    if through is not None and name == "position"
                    else (run.new if name in logged_new else run.held)[name]
                    + noise.get(name, np.zeros(time.size))
                    for name in (signals or run.held)
                }
                made.append(asked.with_signals(columns))
        return made


SERVO = Axis()
BENCH = Axis(
    "motor_bench", "current", {"inertia": 0.0052, "viscous": 0.012}, {}, {"position": 2e-5}
)
QUIET_SERVO = Axis(noise={})


def open_small(twin: FmuTwin, recordings: Sequence[Recording], jobs: int = 1) -> Case:
    """Open the case of a twin and its recordings."""
    return open_case(twin, recordings, seed=0, jobs=jobs, on_run=lambda: None)


def decided(case: Case, names: Sequence[str]) -> Decision:
    """Decide on a few effects alone, which is quicker than on the whole library."""
    why = untestable(
        case.twin.file,
        case.setting.excitation,
        has_inertia=case.setting.inertia is not None,
        is_open=case.simulations.tracking is not None,
    )
    testable = [name for name in names if name not in why]
    assert set(names) <= set(CATALOGUE)
    return decide(case, testable, (), lambda stage, share: None)


def diagnosed(
    twin: FmuTwin, recordings: Sequence[Recording], *, only: Sequence[str] = (), jobs: int = 1
) -> Diagnosis:
    """Diagnose with part of the library: the rest is excluded."""
    excluded = [name for name in CATALOGUE if only and name not in only]
    return diagnose(twin, recordings, exclude=excluded, jobs=jobs)


def named(diagnosis: Diagnosis) -> list[str]:
    """Effects that were named."""
    return [effect.name for effect in diagnosis.effects]
