"""Recordings of a loop whose controller reads noise that a test knows."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gmfbo import FmuTwin
from gmfbo.diagnosis.case.case import Case
from gmfbo.recordings.recording import Recording
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.twin.augmented_twin import AugmentedTwin
from tests.diagnosis.short_recordings import SERVO, Axis, Reference, moves, multisine, open_small

Array = NDArray[np.float64]

STEP = 1e-3


@dataclass(frozen=True, eq=False)
class Planted:
    """Recordings, and the noise of each reading.

    Attributes
    ----------
    twin : FmuTwin
        That of the axis.
    recordings : list of Recording
        Of 1.4 s at 1 kHz.
    noise : list of ndarray, shape (rows,)
        [SI] In each recorded position.
    """

    twin: FmuTwin
    recordings: list[Recording]
    noise: list[Array]


def planted(
    sigma: float,
    physics: Mapping[str, float] | None = None,
    *,
    axis: Axis = SERVO,
    twin: FmuTwin | None = None,
    references: Sequence[Reference] = (multisine, moves),
    seed: int = 3,
    is_felt: bool = True,
) -> Planted:
    """Simulate an axis under white noise of its position sensor.

    Parameters
    ----------
    sigma : float
        [SI] Of the position.
    physics : mapping of str to float, optional
        Of physics.fmu.
    axis : Axis
        Whose truth, gains, and noise of the other signals.
    twin : FmuTwin, optional
        In place of the axis's own.
    references : sequence of callable
        Of the driven input.
    seed : int
        Of all noise.
    is_felt : bool
        The controller reads the noise too, and not the logger alone.
    """
    rng = np.random.default_rng(seed)
    twin = twin or axis.twin()
    time = STEP * np.arange(1400, dtype=np.float64)
    recordings, columns = [], []
    with AugmentedTwin(twin, substeps=10, isolated=False) as simulator:
        for k, reference in enumerate(references):
            asked = Recording(
                time=time,
                signals={axis.driven: reference(time)},
                name=f"rec{k}.csv",
                parameters=axis.gains,
                written_by="test",
            )
            column = sigma * rng.standard_normal(time.size)
            felt = {"sensor": column} if is_felt else None
            plan = simulator.plan(asked, axis.truth)
            run = simulator.run(plan, axis.truth, physics or {}, excitation=felt)
            assert run.outcome.status == "ok", run.outcome.message
            signals = {
                name: values + axis.noise.get(name, 0.0) * rng.standard_normal(time.size)
                for name, values in run.held.items()
                if name != "position"
            }
            signals["position"] = run.states["position"] + column
            recordings.append(asked.with_signals(signals))
            columns.append(column)
    return Planted(twin, recordings, columns)


@contextmanager
def opened(found: Planted) -> Iterator[Case]:
    """Open the case of recordings with planted noise."""
    case = open_small(found.twin, found.recordings)
    try:
        yield case
    finally:
        case.simulations.close()


def servo_without_sensor(folder: Path) -> Path:
    """Twin file of the servo axis whose FMU is said to have no sensor port."""
    text = (models_folder() / "servo_axis.toml").read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if not line.startswith("sensor = ")]
    fmu = (models_folder() / "servo_axis.fmu").as_posix()
    path = folder / "servo_without_sensor.toml"
    path.write_text("\n".join(lines).replace("servo_axis.fmu", fmu), encoding="utf-8")
    return path
