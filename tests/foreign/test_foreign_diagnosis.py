"""`gmfbo diagnose` on a foreign FMU: a twin file is all that it takes."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from gmfbo import FmuTwin, Recording
from gmfbo.physics.catalogue import CATALOGUE
from gmfbo.recordings.writing.writer import write_recording
from gmfbo.sources.twin.augmented_twin import AugmentedTwin
from tests.foreign.fmus import write_vendor_axis

LEVEL = 3.0  # [N] of which the foreign FMU knows nothing
TRIED = (  # the whole library takes many times as long
    "coulomb_friction",
    "elastic_return",
)


def write_recordings(twin: Path) -> list[Path]:
    """What a logger at the axis with friction would store; the controller reads its noise too."""
    time, rng = np.arange(600, dtype=np.float64) * 1e-3, np.random.default_rng(0)
    paths = []
    with AugmentedTwin(FmuTwin(twin), substeps=10) as axis:
        for k, hertz in enumerate([1.7, 2.6, 3.8]):
            wave = {"reference": 0.04 * np.sin(2.0 * np.pi * hertz * time)}
            plan = axis.plan(Recording(time=time, signals=wave), {})
            noise = 2e-5 * rng.standard_normal(time.size)
            truth = {"plant.mass.m": 1.1}
            hidden = {"coulomb_friction.level": LEVEL}
            run = axis.run(plan, truth, hidden, excitation={"sensor": noise})
            logged = {**wave, **run.held, "position": run.states["position"] + noise}
            paths.append(twin.parent / f"run{k}.csv")
            write_recording(Recording(time=time, signals=logged), paths[-1])
    return paths


@pytest.mark.slow
def test_friction_that_a_foreign_fmu_lacks_is_found_by_a_twin_file_alone(tmp_path: Path) -> None:
    twin = write_vendor_axis(tmp_path)
    recordings = write_recordings(twin)
    excluded = [word for name in CATALOGUE if name not in TRIED for word in ("--exclude", name)]
    command = [sys.executable, "-m", "gmfbo", "diagnose", twin.name, *map(str, recordings)]
    command += ["--out", "found", *excluded]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    found = json.loads((tmp_path / "found" / "diagnosis.json").read_text())
    assert found["verdict"] == "missing_physics"
    (effect,) = found["effects"]
    assert (effect["name"], effect["port"]) == ("coulomb_friction", "torque")
    level = effect["parameters"]["level"]
    assert level["unit"] == "N"
    assert abs(level["value"] - LEVEL) < 0.05 * LEVEL
    mass = found["parameters"]["plant.mass.m"]
    assert abs(mass["value"] - 1.1) < 0.02
    errors = found["fit"]["signals"]["position"]
    assert errors["augmented"] < 0.2 * errors["parameters_only"]
    # Its exporter made it for this system alone, and so is what is exported.
    with FmuTwin(tmp_path / "found" / "augmented.toml") as augmented:
        run = augmented.run({}, Recording.read(recordings[2], augmented))
    assert run.status == "ok"
    position = Recording.read(recordings[2]).signals["position"]
    assert np.sqrt(np.mean((run.signals["position"] - position) ** 2)) < 0.01 * np.ptp(position)
