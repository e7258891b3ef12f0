"""What a diagnosis reports is what its exported FMU simulates, in any FMI tool."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description
from fmpy.validation import validate_fmu

from gmfbo.diagnosis.diagnosis import Diagnosis
from gmfbo.recordings.recording import Recording
from tests.diagnosis.short_recordings import (
    LOOP,
    SERVO,
    SERVO_GAINS,
    diagnosed,
    moves,
    multisine,
    named,
)

ALONE = """
import json, sys
import numpy as np
from fmpy import simulate_fmu

fmu, reference, outputs, starts, answer = json.load(sys.stdin)
reference = np.array(reference)
grid = 1e-3 * np.arange(reference.size)
column = np.array(list(zip(grid, reference)), dtype=[("time", float), ("reference", float)])
result = simulate_fmu(
    fmu, start_values=starts, input=column, output=outputs, stop_time=float(grid[-1]),
    step_size=1e-3, output_interval=1e-3, set_stop_time=False,
)
assert "gmfbo" not in sys.modules
with open(answer, "w") as file:
    json.dump({name: result[name].tolist() for name in outputs}, file)
"""


@pytest.fixture(scope="module")
def recordings() -> list[Recording]:
    """Two runs of a servo with friction that its twin does not have."""
    hidden = {"coulomb_friction.level": 0.2}
    return SERVO.recordings(hidden, [multisine, moves])


@pytest.fixture(scope="module")
def found(recordings: list[Recording]) -> Diagnosis:
    """Their diagnosis with all ports."""
    with SERVO.twin() as twin:
        return diagnosed(twin, recordings, only=LOOP)


def test_friction_is_named_at_its_size_out_of_what_all_ports_show(found: Diagnosis) -> None:
    assert found.verdict == "missing_physics"
    assert found.evidence == "sufficient"
    assert named(found) == ["coulomb_friction"]
    assert found.effects[0].parameters["level"].value == pytest.approx(0.2, rel=0.02)
    assert found.location.signal_path == "plant"
    assert found.parameters["inertia"].value == pytest.approx(0.0105, rel=0.02)
    removed = found.fit.explainable_error_removed
    assert removed is not None
    assert removed > 0.95


def test_plain_fmpy_gives_the_trajectories_that_are_reported(
    found: Diagnosis, recordings: list[Recording], tmp_path: Path
) -> None:
    found.save(tmp_path)
    for recording in recordings:
        curves = {c.signal: c for c in found.curves if c.recording == recording.name}
        asked = recording.signal("reference").tolist()
        outputs = ["position", "torque_command"]
        order = json.dumps(
            [str(tmp_path / "augmented.fmu"), asked, outputs, SERVO_GAINS, str(tmp_path / "a.json")]
        )
        subprocess.run(
            [sys.executable, "-c", ALONE], input=order, text=True, check=True, cwd=tmp_path
        )
        answer = json.loads((tmp_path / "a.json").read_text())
        for name, column in answer.items():
            curve = curves[name]
            rows = np.round(curve.time / 1e-3).astype(int)
            simulated = np.array(column)[rows]
            extent = float(np.ptp(curve.augmented))
            np.testing.assert_allclose(simulated, curve.augmented, rtol=0.0, atol=1e-9 * extent)


def test_the_exported_fmu_is_valid_with_the_units_and_bounds_of_the_original(
    found: Diagnosis, tmp_path: Path
) -> None:
    found.save(tmp_path)
    exported = tmp_path / "augmented.fmu"
    assert validate_fmu(str(exported)) == []
    with SERVO.twin() as twin:
        original = read_model_description(str(twin.binding.fmus[0].path))
    new = {v.name: v for v in read_model_description(str(exported)).modelVariables}
    for variable in original.modelVariables:
        if variable.causality in ("input", "output", "parameter"):
            twin_of_it = new[variable.name]
            assert (twin_of_it.unit, twin_of_it.min, twin_of_it.max) == (
                variable.unit,
                variable.min,
                variable.max,
            )
