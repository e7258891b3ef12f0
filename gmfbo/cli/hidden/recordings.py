"""Recordings of the demo's real axis, as its drive would log them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from gmfbo.cli.hidden.references import SAMPLE_S, references
from gmfbo.errors import SimulationError

_AT_REST_S = 0.4  # [s] under control before the logger starts, for transients to end


def record(plant: Mapping[str, float], seed: int, folder: Path) -> list[Path]:
    """Run the axis along every reference and store what its logger sees.

    Parameters
    ----------
    plant : mapping of str to float
        Parameters of models/demo_axis.fmu, hidden physics included.
    seed : int
        Of the encoder's noise.
    folder : Path
        Where the files go; it exists.

    Returns
    -------
    list of Path
        `run0.csv` and so on: time, reference, position and torque command, nothing else.

    Raises
    ------
    SimulationError
        The axis did not come to the end of a run.
    """
    from gmfbo.recordings.recording import Recording
    from gmfbo.recordings.writing.writer import write_recording
    from gmfbo.sources.fmu_file.models import models_folder
    from gmfbo.sources.twin.twin import FmuTwin

    noise = np.random.default_rng((seed, 2)).integers(2**31, size=len(references()))
    lead = round(_AT_REST_S / SAMPLE_S)
    written = []
    with FmuTwin(models_folder() / "demo_axis.toml") as axis:
        for number, reference in enumerate(references()):
            asked = np.concatenate([np.full(lead, reference[0]), reference])
            time = SAMPLE_S * np.arange(asked.size, dtype=np.float64)
            run = axis.run(
                {},
                Recording(time=time, signals={"reference": asked}),
                parameters={**plant, "encoder.seed": float(noise[number])},
            )
            if run.status != "ok":
                raise SimulationError(f"the axis of the demo stopped early: {run.message}")
            logged = ("reference", "position", "torque_command")
            recording = Recording(
                time=SAMPLE_S * np.arange(reference.size, dtype=np.float64),
                signals={name: run.signals[name][lead:] for name in logged},
                units={name: run.units[name] for name in logged},
            )
            written.append(write_recording(recording, folder / f"run{number}.csv"))
    return written
