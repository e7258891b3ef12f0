"""Cases of a draw: nothing of the truth lies where the diagnosis reads, and seeds decide all."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from gmfbo import FmuTwin, Recording
from tests.blind.draw.cases import make_drawn, size_class
from tests.blind.draw.mujoco_axis import WHY_NOT, has_mujoco
from tests.blind.draw.nulls import VARIANTS
from tests.blind.draw.plan import DrawnCase
from tests.blind.plan import Plan

NEEDS_MUJOCO = pytest.mark.skipif(not has_mujoco(), reason=WHY_NOT)
FAST = [
    pytest.param(family, name, marks=[NEEDS_MUJOCO, pytest.mark.slow])
    if family == "simulator"
    else pytest.param(family, name, marks=pytest.mark.slow)
    if name == "many"  # builds an FMU
    else (family, name)
    for family, own in VARIANTS.items()
    for name in own
]


OF_ANY_TWIN_FILE = {"parameters", "inertia", "viscous", "filter_time", "torque_lag"}
"""Words that stand in the twin file of a case of any kind."""


def case_of(family: str, name: str) -> DrawnCase:
    """A null of this variant on its first machine."""
    return DrawnCase("null", family, name, Plan("null", VARIANTS[family][name].machines[0]))


@pytest.mark.parametrize(("family", "name"), FAST)
def test_the_truth_is_in_nothing_that_the_diagnosis_reads(
    family: str, name: str, tmp_path: Path
) -> None:
    folder = tmp_path / "cases" / "000"
    answer = make_drawn(case_of(family, name), 9, 0, folder, tmp_path / "models")
    files = sorted(path.name for path in folder.iterdir())
    recordings = [file for file in files if file.startswith("rec")]
    assert files == [*(f"rec{k}.csv" for k in range(len(recordings))), "twin.toml"]
    texts = {file: (folder / file).read_text(encoding="utf-8") for file in files}
    words = {family, name, *answer.details["rig"], "certificate", "mujoco", "null", "stratum"}
    for text in texts.values():
        named = set(re.findall(r"[a-z_]+", text.lower()))
        assert not named & (words - OF_ANY_TWIN_FILE)
    hidden = {f"{entry['true']!r}" for entry in answer.parameters.values() if "exact" not in name}
    hidden |= {repr(answer.details["fixed"]["true"])} if "fixed" in answer.details else set()
    believed = {repr(entry["nominal"]) for entry in answer.parameters.values()}
    assert not any(value in text for value in hidden - believed for text in texts.values())


@pytest.mark.parametrize(
    ("family", "name"),
    [
        ("logger", "noise"),
        ("loop", "fast_averaged"),
        pytest.param("parameters", "many", marks=pytest.mark.slow),
        pytest.param("simulator", "mujoco", marks=[NEEDS_MUJOCO, pytest.mark.slow]),
    ],
)
def test_the_same_seed_gives_the_same_bytes(family: str, name: str, tmp_path: Path) -> None:
    """And another seed others."""
    made = []
    for run, seed in (("a", 9), ("b", 9), ("c", 10)):
        folder = tmp_path / run / "cases" / "000"
        answer = make_drawn(case_of(family, name), seed, 0, folder, tmp_path / run / "models")
        files = {path.name: path.read_bytes() for path in sorted(folder.iterdir())}
        made.append((answer.text(), files))
    assert made[0] == made[1]
    assert made[0][1]["rec0.csv"] != made[2][1]["rec0.csv"]


@pytest.mark.parametrize(
    ("family", "name"),
    [("logger", "counts"), ("timing", "jitter_of_rows"), ("loop", "torque_noise")],
)
def test_the_recordings_of_a_null_can_be_read_by_its_twin(
    family: str, name: str, tmp_path: Path
) -> None:
    folder = tmp_path / "cases" / "000"
    make_drawn(case_of(family, name), 9, 0, folder, tmp_path / "models")
    with FmuTwin(folder / "twin.toml") as twin:
        read = Recording.read(folder / "rec0.csv", twin)
    assert {"reference", "position"} < set(read.signals)
    assert np.all(np.isfinite(read.signal("position")))


def test_a_wrong_fixed_parameter_is_that_and_nothing_else(tmp_path: Path) -> None:
    folder = tmp_path / "cases" / "000"
    answer = make_drawn(case_of("fixed", "torque_lag"), 9, 0, folder, tmp_path / "models")
    fixed = answer.details["fixed"]
    ratio = max(fixed["true"] / fixed["believed"], fixed["believed"] / fixed["true"])
    assert 1.3 <= ratio <= 2.0
    assert fixed["name"] == "torque_lag"
    assert '"torque_lag" = 0.0005' in (folder / "twin.toml").read_text(encoding="utf-8")
    assert json.loads(answer.text())["effects"] == []


def test_an_unidentifiable_parameter_is_uncertain_and_no_longer_fixed(tmp_path: Path) -> None:
    folder = tmp_path / "cases" / "000"
    case = case_of("parameters", "unidentifiable")
    make_drawn(case, 9, 0, folder, tmp_path / "models")
    text = (folder / "twin.toml").read_text(encoding="utf-8")
    assert '"plant.torque_constant" = [' in text.split("[uncertain]")[1]


@pytest.mark.slow
@NEEDS_MUJOCO
def test_the_certificate_of_a_case_stands_in_its_answer_and_holds(tmp_path: Path) -> None:
    folder = tmp_path / "cases" / "000"
    answer = make_drawn(case_of("simulator", "mujoco"), 9, 0, folder, tmp_path / "models")
    shown = answer.details["certificate"]
    assert shown["step"] == answer.details["rig"]["mujoco_step"]
    for at in ("at_step", "at_half_step"):
        assert all(share < 0.25 for share in shown[at].values())


def test_size_classes_are_bounded_by_oracle_gains() -> None:
    gains = (1.0, 15.0, 60.0, 250.0, 1e3, 1e4)
    names = ["below", "around", "above", "clear", "large", "huge"]
    assert [size_class(gain) for gain in gains] == names
