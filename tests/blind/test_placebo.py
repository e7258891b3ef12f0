"""Placebos change what they say, and nothing else."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from gmfbo import FmuTwin, Recording
from tests.blind import cases
from tests.blind.cases import make_case
from tests.blind.generate import answer_path, check_hashes, write_hashes
from tests.blind.oracle import Oracle
from tests.blind.placebo import FASTER_THAN, make_placebo, with_noise
from tests.blind.plan import Plan

PLANS = (
    Plan("null", "servo"),
    Plan("null", "servo"),
    Plan("single", "servo", ("coulomb_friction",)),
    Plan("single", "servo_none", ("coulomb_friction",)),
)


@pytest.fixture(scope="module")
def benchmark(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("benchmark")
    (out / "answers").mkdir()
    with pytest.MonkeyPatch.context() as patch:
        # Of any size: no placebo asks how much an effect shows.
        patch.setattr(cases, "size_for_gain", lambda law, shaped, setting, *_: law.low(setting))
        patch.setattr(Oracle, "gain", lambda *_: 100.0)
        for index, plan in enumerate(PLANS):
            answer = make_case(plan, 21, index, out / "cases" / f"{index:03d}")
            answer_path(out, index).write_text(answer.text(), encoding="utf-8")
    (out / "benchmark.json").write_text('{"cases": 4, "seed": 21}', encoding="utf-8")
    write_hashes(out)
    return out


def _text(folder: Path, case: str, name: str) -> str:
    return (folder / "cases" / case / name).read_text(encoding="utf-8")


def test_a_swap_exchanges_two_recordings_of_two_units(benchmark: Path, tmp_path: Path) -> None:
    assert make_placebo("swap", benchmark, tmp_path / "p", 24) == ["000", "001"]
    for name in ("rec0.csv", "rec2.csv"):
        assert _text(tmp_path / "p", "000", name) == _text(benchmark, "000", name)
    for name in ("rec1.csv", "rec3.csv"):
        assert _text(tmp_path / "p", "000", name) == _text(benchmark, "001", name)
        assert _text(tmp_path / "p", "001", name) == _text(benchmark, "000", name)
    assert check_hashes(tmp_path / "p") == ["000", "001"]


def test_the_true_effect_is_excluded_with_its_family(benchmark: Path, tmp_path: Path) -> None:
    """Where the twin has no port there is nothing to exclude."""
    assert make_placebo("exclude", benchmark, tmp_path / "p", 24) == ["002"]
    words = json.loads((tmp_path / "p" / "arguments" / "002.json").read_text(encoding="utf-8"))
    assert {"coulomb_friction", "stribeck_friction"} <= set(words[1::2])
    assert set(words[::2]) == {"--exclude"}


def test_the_gain_is_wrong_in_twin_and_recordings_and_the_twin_runs(
    benchmark: Path, tmp_path: Path
) -> None:
    assert make_placebo("gain", benchmark, tmp_path / "p", 24, ["000", "002"]) == ["000", "002"]
    for name in ("twin.toml", "rec0.csv"):
        pattern = r'^(?:# kp|"kp") = ([\d.]+)'
        before = re.search(pattern, _text(benchmark, "000", name), re.MULTILINE)
        after = re.search(pattern, _text(tmp_path / "p", "000", name), re.MULTILINE)
        assert before is not None
        assert after is not None
        assert float(after[1]) == pytest.approx(1.05 * float(before[1]), rel=1e-5)
    folder = tmp_path / "p" / "cases" / "000"
    with FmuTwin(folder / "twin.toml") as twin:
        recording = Recording.read(folder / "rec0.csv", twin)
        assert twin.run({}, recording).status == "ok"


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_only_what_is_faster_than_mechanics_is_scaled(benchmark: Path, factor: float) -> None:
    before = _text(benchmark, "000", "rec0.csv")
    tables = [
        np.array([line.split(",") for line in text.splitlines()[3:]], dtype=float)
        for text in (before, with_noise(before, factor))
    ]
    np.testing.assert_array_equal(tables[0][:, :2], tables[1][:, :2])  # time and reference
    for column in (2, 3):
        old, new = (np.abs(np.fft.rfft(table[:, column])) for table in tables)
        fast = np.fft.rfftfreq(len(tables[0]), 1e-3) > FASTER_THAN
        size = np.max(old)
        np.testing.assert_allclose(new[~fast], old[~fast], rtol=1e-6, atol=1e-6 * size)
        np.testing.assert_allclose(new[fast], factor * old[fast], rtol=1e-4, atol=1e-6 * size)


def test_no_case_that_suits_is_an_error(benchmark: Path, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="found none"):
        make_placebo("swap", benchmark, tmp_path / "p", 24, ["002"])
