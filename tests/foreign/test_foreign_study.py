"""A study tunes with a foreign FMU as its twin, and with ours by changing one line."""

from __future__ import annotations

import difflib
from pathlib import Path

import numpy as np
import pytest

from gmfbo import Study, Tuner
from tests.foreign.fmus import write_own_axis, write_vendor_axis

STUDY = """
method = "gmfbo_paper"
[is1]
twin = "own.toml"
parameters = { "plant.viscous_friction" = 25.0, "plant.mass" = 1.2 }
[is2]
twin = "vendor.toml"
[reference]
step = 0.01
at = 0.05
horizon = 0.15
[objective]
normalise = 4
[budget]
initial_is1 = 2
initial_is2 = 4
is1_runs = 3
is3_per_run = 1
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_vendor_axis(tmp_path)
    write_own_axis(tmp_path)
    (tmp_path / "vendor_study.toml").write_text(STUDY)
    swapped = STUDY.replace('[is2]\ntwin = "vendor.toml"', '[is2]\ntwin = "own.toml"')
    (tmp_path / "own_study.toml").write_text(swapped)
    return tmp_path


def test_the_same_study_runs_with_either_twin_by_changing_one_line(folder: Path) -> None:
    vendor, own = (
        (folder / f"{name}_study.toml").read_text().splitlines() for name in ("vendor", "own")
    )
    changed = [line for line in difflib.ndiff(vendor, own) if line[0] in "+-"]
    assert changed == ['- twin = "vendor.toml"', '+ twin = "own.toml"']
    best = []
    for name in ("vendor", "own"):
        with Tuner(Study.read(folder / f"{name}_study.toml")) as tuner:
            result = tuner.run()
        assert result.best is not None
        best.append(result.best)
        study = Study.read(folder / f"{name}_study.toml")
        sources = [trial.source for trial in study.trials]
        assert sources.count("IS1") == 3
        assert sources.count("IS2") >= 7
        assert {trial.status for trial in study.trials} == {"ok"}
    # Both twins are right but for friction and mass: what they recommend is as good on the axis.
    assert abs(best[0].metrics["rise_time"] - best[1].metrics["rise_time"]) < 0.01
    assert np.isfinite([trial.objective for trial in best]).all()
