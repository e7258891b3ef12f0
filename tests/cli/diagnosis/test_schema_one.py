"""A `diagnosis.json` of schema 1, as version 0.1 wrote it: `compensate` takes it, others do not."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from gmfbo.cli import main
from gmfbo.sources.fmu_file.models import models_folder

TWIN = models_folder() / "servo_axis.toml"
EXAMPLE = """{
 "schema": 1,
 "verdict": "missing_physics",
 "evidence": "sufficient",
 "effects": [
  {"name": "coulomb_friction", "port": "torque", "probability": 0.97,
   "statement": "Coulomb friction of about 0.52 N m at the motor shaft is missing from the twin.",
   "equation": "tau = -F_c * sign(omega)",
   "parameters": {"level": {"value": 0.52, "unit": "N.m", "low": 0.49, "high": 0.55}},
   "evidence": 412.0, "threshold": 18.3, "evidence_per_recording": {"rec3.csv": 300.1},
   "indistinguishable_from": []}],
 "parameters": {"inertia": {"nominal": 0.01, "value": 0.0101, "unit": "kg.m2", "low": 0.0099,
  "high": 0.0103, "identifiable": true}},
 "combinations": [{"expression": "inertia / viscous", "value": 0.119, "low": 0.118,
  "high": 0.120}],
 "alignment": {"torque_command": {"logged": "held", "shift": 0.0, "scale": 1.0, "offset": 0.0}},
 "detectable": {"backlash": {"gap": 8e-4, "unit": "rad"}},
 "location": {"signal_path": "plant",
              "region": "where the velocity changes sign", "times": [["rec0.csv", 0.41, 0.47]]},
 "fit": {"fitted_on": ["rec0.csv"], "held_out": ["rec3.csv"],
         "signals": {"position": {"nominal": 0.021, "parameters_only": 0.019, "augmented": 0.002,
                                  "unnamed_spline": 0.004, "noise_floor": 0.0018},
                     "torque_command": {"nominal": 0.31, "parameters_only": 0.30,
                                        "augmented": 0.06, "unnamed_spline": 0.09,
                                        "noise_floor": 0.05}},
         "explainable_error_removed": 0.98},
 "shape": null,
 "next_experiment": null,
 "not_testable": [{"name": "sensor_lag", "why": "the twin has no sensor port"}],
 "cost": {"simulations": 612, "seconds": 14.2}, "seed": 0, "versions": {"gmfbo": "0.1.0"}
}"""
"""The published example of schema 1, told of the servo axis."""

PREDICTIONS = {
    "explanations": [
        {"name": "coulomb_friction", "effects": ["coulomb_friction"],
         "parameters": {"inertia": 0.0101, "viscous": 0.02},
         "physics": {"coulomb_friction.level": 0.52}, "misfit": 1.0}
    ],
    "threshold": 30.0,
    "noise": {"position": 3e-5, "torque_command": 0.02},
    "spans": {
        name: {"low": -4.0, "high": 4.0, "unit": unit}
        for name, unit in {"position": "rad", "velocity": "rad/s", "command": "N.m",
                           "current": "N.m", "load": "N.m", "torque": "N.m"}.items()
    },
    "new_rows": [],
}  # fmt: skip
"""What the last builds of version 0.1 wrote beside it."""


@pytest.fixture
def found(tmp_path: Path) -> Path:
    (tmp_path / "diagnosis.json").write_text(EXAMPLE)
    return tmp_path


def answer(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str, str]:
    code = main([str(argument) for argument in arguments])
    told = capsys.readouterr()
    return code, " ".join(told.out.split()), told.err


@pytest.mark.parametrize("ending", ["csv", "c", "st"])
def test_the_published_example_is_compensated_with_a_smoothing(
    ending: str, found: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = found / f"friction.{ending}"
    code, told, _ = answer(capsys, "compensate", found, "--out", out, "--smoothing", "0.1")
    assert code == 0
    assert "torque at the motor shaft [N.m]: coulomb_friction(velocity)" in told
    assert "-0.52 to 0.52 N m over the velocity from -12.5 to 12.5 rad/s" in told
    assert "note this older diagnosis does not say how fast the axis moved" in told
    assert "0.52" in out.read_text()


def test_without_a_smoothing_one_line_asks_for_it(
    found: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, _, told = answer(capsys, "compensate", found, "--out", found / "friction.c")
    assert (code, told.count("\n")) == (2, 1)
    assert "give --smoothing VELOCITY, 1 % of the fastest motion, or diagnose again" in told
    assert not (found / "friction.c").exists()


@pytest.mark.parametrize(
    ("was", "became", "line"),
    [
        # A level in mN m was written as one in N m, a thousand times too large.
        ('"unit": "N.m"', '"unit": "mN.m"', "got mN.m; diagnose again"),
        (
            '"value": 0.52',
            '"value": null',
            "expected a number for level of coulomb friction, got none",
        ),
    ],
)
def test_what_is_no_table_is_refused_in_one_line(
    was: str, became: str, line: str, found: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (found / "diagnosis.json").write_text(EXAMPLE.replace(was, became))
    out = found / "friction.c"
    code, _, told = answer(capsys, "compensate", found, "--out", out, "--smoothing", "0.05")
    assert (code, told.count("\n")) == (2, 1)
    assert line in told
    assert not out.exists()


def test_where_the_recorded_ranges_were_saved_no_smoothing_is_needed(
    found: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    whole = {**json.loads(EXAMPLE), "predictions": PREDICTIONS}
    (found / "diagnosis.json").write_text(json.dumps(whole))
    code, told, _ = answer(capsys, "compensate", found, "--out", found / "friction.csv")
    assert code == 0
    assert "over the velocity from -5 to 5 rad/s" in told
    assert "older" not in told


@pytest.mark.parametrize("more", [["--limits", "limits.toml", "--out", "next.csv"], ["--observed"]])
def test_an_experiment_asks_to_diagnose_again(
    more: list[str],
    found: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(found)
    (found / "limits.toml").write_text(
        "position = [-0.5, 0.5]\nvelocity = 6.0\nacceleration = 100.0\nduration = 3.0\n"
    )
    seen = ["seen.csv"] if "--observed" in more else []
    code, _, told = answer(capsys, "experiment", TWIN, "--diagnosis", found, *more, *seen)
    assert (code, told.count("\n")) == (2, 1)
    assert "made by gmfbo 0.1" in told
    assert "diagnose again" in told
    assert not (found / "next.csv").exists()
