"""Outcomes that are kept as text are scored as the folder that they come from."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

import pytest

from tests.blind.outcomes import keep, take
from tests.blind.score import read_scores
from tests.blind.test_score import answer, diagnosis


def folder(path: Path, seed: int, said: dict[str, dict[str, Any]]) -> Path:
    """A benchmark of three cases, some of them diagnosed."""
    (path / "answers").mkdir(parents=True)
    (path / "benchmark.json").write_text(json.dumps({"cases": 3, "seed": seed}))
    hashes = ""
    for case, hidden in (("000", ("cogging_torque",)), ("001", ()), ("002", ("backlash",))):
        kind = "single" if hidden else "null"
        written = path / "answers" / f"{case}.json"
        written.write_text(json.dumps(answer(*hidden, kind=kind, case=case)))
        hashes += f"{hashlib.sha256(written.read_bytes()).hexdigest()} {case}.json\n"
    (path / "answers.sha256").write_text(hashes)
    for case, diagnosed in said.items():
        results = path / "results" / case
        results.mkdir(parents=True)
        outcome = {
            "status": 0 if diagnosed else -1,
            "seconds": 9.5,
            "note": "" if diagnosed else "?",
        }
        (results / "outcome.json").write_text(json.dumps(outcome))
        if diagnosed:
            (results / "diagnosis.json").write_text(json.dumps(diagnosed))
    return path


def test_kept_outcomes_are_scored_alike(tmp_path: Path) -> None:
    """A right name, a false one and a failed run; what no score needs is left out of the text."""
    right = diagnosis("cogging_torque", latent=["a long curve"])
    said = {"000": right, "001": diagnosis("coulomb_friction"), "002": {}}
    one, other = folder(tmp_path / "one", 5, said), folder(tmp_path / "other", 5, {})
    file = tmp_path / "said.jsonl"
    assert keep(one, file) == 3
    assert take(other, file) == 3
    assert read_scores(other) == read_scores(one)
    assert [score.outcome for score in read_scores(other)] == ["right", "wrong", "failed"]
    assert "a long curve" not in file.read_text()


def test_an_outcome_that_is_there_stays(tmp_path: Path) -> None:
    one = folder(tmp_path / "one", 5, {"000": diagnosis(), "001": diagnosis()})
    other = folder(tmp_path / "other", 5, {"000": diagnosis("cogging_torque")})
    keep(one, tmp_path / "said.jsonl")
    assert take(other, tmp_path / "said.jsonl") == 1
    assert read_scores(other)[0].named == ("cogging_torque",)


def test_outcomes_of_another_seed_are_refused(tmp_path: Path) -> None:
    one, other = folder(tmp_path / "one", 5, {}), folder(tmp_path / "other", 6, {})
    keep(one, tmp_path / "said.jsonl")
    with pytest.raises(ValueError, match="'seed': 5"):
        take(other, tmp_path / "said.jsonl")
