"""A study goes on where its plant crashes: a crash costs one run, which is kept and priced."""

from __future__ import annotations

from pathlib import Path

import pytest

from gmfbo import Study, Trajectory, Tuner

FAULTS = Path(__file__).resolve().parents[1] / "fmus" / "faults"
TWIN = """
name = "{name}"
fmu = '{fmu}'
step = 1e-3
[inputs]
reference = "reference"
[outputs]
position = "position"
[gains]
"at" = [0.0, 0.3]
"gain" = [0.5, 1.5]
"""
STUDY = """
seed = 0
method = "random"
[is1]
twin = "segfault_in_step.toml"
[is2]
twin = "none.toml"
[reference]
step = 1.0
at = 0.05
horizon = 0.1
[budget]
initial_is1 = 2
initial_is2 = 10
is1_runs = 6
"""
LAST_STEP_S = 0.149


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="its FMUs are built for Linux")
def test_a_study_goes_on_where_its_plant_crashes(tmp_path: Path) -> None:
    for name in ("segfault_in_step", "none"):
        text = TWIN.format(name=name, fmu=FAULTS / f"{name}.fmu")
        (tmp_path / f"{name}.toml").write_text(text)
    (tmp_path / "study.toml").write_text(STUDY)
    with Tuner(Study.read(tmp_path / "study.toml")) as tuner:
        best = tuner.run().best
        trials = tuner.history.of("IS1")
    assert len(trials) == 6
    ended = [trial.recording.status for trial in trials if isinstance(trial.recording, Trajectory)]
    crashed = [trial for trial, how in zip(trials, ended, strict=True) if how == "crashed"]
    well = [trial for trial, how in zip(trials, ended, strict=True) if how == "ok"]
    assert len(crashed) + len(well) == 6
    # The plant crashes in the first step that begins at `at` or later.
    assert crashed
    assert all(trial.gains["at"] <= LAST_STEP_S for trial in crashed)
    assert well
    assert all(trial.gains["at"] > LAST_STEP_S for trial in well)
    assert best is not None
    assert best.gains["at"] > LAST_STEP_S
    assert max(t.objective for t in well) < min(t.objective for t in crashed)
