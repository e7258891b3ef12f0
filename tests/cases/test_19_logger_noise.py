"""Noise of the logger, which the controller never read, on a twin that lacks nothing or friction.

The recordings of the case lack nothing; those with friction are made here, like those of gen.py.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gmfbo import FmuTwin, Recording, models_folder
from gmfbo.sources.twin.augmented_twin import AugmentedTwin
from tests.cases.case_folder import CaseFolder, needs_case

CASE = "19-logger-noise"
TWIN = models_folder() / "servo_axis.toml"
INERTIA, FRICTION = 0.0105, 0.2  # [kg.m2] 5 % off the twin's, [N.m] at the shaft
NOISE = 3e-5  # [rad] of the logged position alone


@pytest.mark.slow
@needs_case(CASE)
def test_the_inertia_is_told_and_nothing_is_missing(case: CaseFolder) -> None:
    answer = case.gmfbo(f"diagnose {TWIN} null*.csv --out f")
    assert answer.code == 0
    assert "no physics is missing" in answer.out
    found = case.json("f/diagnosis.json")
    assert found["verdict"] == "parameters"
    assert found["effects"] == []
    assert not any(one["fixed"] for one in found["parameters"].values())
    inertia = found["parameters"]["inertia"]
    assert inertia["low"] <= INERTIA <= inertia["high"]


@pytest.mark.slow
def test_hidden_friction_is_told(tmp_path: Path) -> None:
    write_recordings_with_friction(tmp_path)
    folder = CaseFolder(tmp_path)
    answer = folder.gmfbo(f"diagnose {TWIN} run*.csv --out f")
    assert answer.code == 0
    found = folder.json("f/diagnosis.json")
    assert found["verdict"] == "missing_physics"
    assert [effect["name"] for effect in found["effects"]] == ["coulomb_friction"]
    level = found["effects"][0]["parameters"]["level"]
    assert level["low"] <= FRICTION <= level["high"]
    inertia = found["parameters"]["inertia"]
    assert inertia["low"] <= INERTIA <= inertia["high"]


def write_recordings_with_friction(folder: Path) -> None:
    """Four sines of the reference; the logger's position has noise that no controller read."""
    time, rng = np.arange(2500, dtype=np.float64) * 1e-3, np.random.default_rng(0)
    with AugmentedTwin(FmuTwin(TWIN), substeps=10) as axis:
        for k, hertz in enumerate([0.5, 0.9, 1.4, 2.3]):
            wave = {"reference": 0.4 * np.sin(2.0 * np.pi * hertz * time)}
            plan = axis.plan(Recording(time=time, signals=wave), {})
            noise = NOISE * rng.standard_normal(time.size)
            run = axis.run(plan, {"inertia": INERTIA}, {"coulomb_friction.level": FRICTION})
            position, torque = run.states["position"] + noise, run.held["torque_command"]
            np.savetxt(
                folder / f"run{k}.csv",
                np.column_stack([time, wave["reference"], position, torque]),
                fmt="%.8g",
                delimiter=",",
                header="time,reference,position,torque_command",
                comments="",
            )
