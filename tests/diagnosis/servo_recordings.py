"""Recordings of the servo axis with hidden physics, for tests of the diagnosis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gmfbo import FmuTwin
from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.case.open_case import open_case
from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin.augmented_twin import AugmentedTwin

MODELS = Path(__file__).parents[2] / "models"
SERVO = MODELS / "servo_axis.toml"
HIDDEN = {"inertia": 0.0105, "viscous": 0.03}
GAINS = {"kp": 40.0, "kd": 0.8}
POSITION_NOISE, COMMAND_NOISE = 3e-5, 0.02


def references() -> tuple[NDArray[np.float64], list[NDArray[np.float64]]]:
    """Return time, and a multisine, two moves and a triangle of two seconds each."""
    t = np.arange(2000, dtype=np.float64) * 1e-3
    tones = [(0.7, 0.1), (1.3, 2.0), (2.9, 4.2), (5.1, 5.5)]
    multisine = np.sum([0.15 * np.sin(2.0 * np.pi * f * t + p) for f, p in tones], axis=0)
    ramps = np.clip((t - 0.2) * 4.0, 0.0, 1.0) - np.clip((t - 1.1) * 3.0, 0.0, 1.5)
    triangle = 0.5 * np.abs(((t * 0.8) % 2.0) - 1.0) - 0.5
    return t, [multisine * np.minimum(1.0, t / 0.3), ramps, triangle]


def hidden_servo(
    physics: Mapping[str, float],
    *,
    twin: FmuTwin | None = None,
    stated: Mapping[str, float] = GAINS,
    parameters: Mapping[str, float] | None = None,
    new_command: bool = False,
) -> tuple[FmuTwin, list[Recording]]:
    """Simulate the axis with physics that its twin lacks, and add a sensor's noise.

    The controller reads the noise that the logger stores, as it does on a drive.
    """
    twin = twin or FmuTwin(SERVO)
    rng = np.random.default_rng(5)
    time, columns = references()
    recordings = []
    with AugmentedTwin(FmuTwin(SERVO), substeps=10, isolated=False) as simulator:
        for k, column in enumerate(columns):
            recording = Recording(
                time=time, signals={"reference": column}, name=f"rec{k}.csv", parameters=GAINS
            )
            truth = {**HIDDEN, **(parameters or {})}
            noise = POSITION_NOISE * rng.standard_normal(time.size)
            plan = simulator.plan(recording, truth)
            run = simulator.run(plan, truth, physics, excitation={"sensor": noise})
            command = (run.new if new_command else run.held)["torque_command"]
            signals = {
                "reference": column,
                "position": run.states["position"] + noise,
                "torque_command": command + COMMAND_NOISE * rng.standard_normal(time.size),
            }
            recordings.append(
                Recording(
                    time=time,
                    signals=signals,
                    name=recording.name,
                    parameters=dict(stated),
                    written_by="test",
                )
            )
    return twin, recordings


def opened(physics: Mapping[str, float]) -> Case:
    """Open the case of a servo axis with hidden physics."""
    return opened_with(*hidden_servo(physics))


def opened_with(twin: FmuTwin, recordings: Sequence[Recording]) -> Case:
    """Open the case of a twin and its recordings, with one simulator."""
    return open_case(twin, recordings, seed=0, jobs=1, on_run=lambda: None)


def rewritten(model: str, folder: Path, replacements: Mapping[str, str]) -> FmuTwin:
    """Return the twin of one of the models, `servo_axis` say, with its file changed."""
    text = (MODELS / f"{model}.toml").read_text()
    fmu = {f'"{model}.fmu"': f'"{MODELS / model}.fmu"'}
    for old, new in {**fmu, **replacements}.items():
        assert old in text
        text = text.replace(old, new)
    path = folder / f"{model}.toml"
    path.write_text(text)
    return FmuTwin(path)


def certain(model: str, folder: Path) -> FmuTwin:
    """Return the twin of one of the models with no parameter left to refit."""
    lines = (MODELS / f"{model}.toml").read_text().splitlines()
    first = lines.index("[uncertain]")
    last = lines.index("", first)
    return rewritten(model, folder, {"\n".join(lines[first:last]): ""})
