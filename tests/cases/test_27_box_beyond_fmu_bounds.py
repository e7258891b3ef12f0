"""What cannot be played is refused before the first run."""

from __future__ import annotations

import pytest

from tests.cases.case_folder import CaseFolder, needs_case

CASE = "27-box-beyond-fmu-bounds"
pytestmark = needs_case(CASE)


@pytest.mark.parametrize("study", ["oob", "oobp1"])
def test_a_box_beyond_the_bounds_of_the_fmu_is_refused(case: CaseFolder, study: str) -> None:
    answer = case.gmfbo(f"tune {study}.toml --random-start")
    assert answer.code == 2
    assert "'ctl.Kp': expected a range within [0, 2000]" in answer.err
    assert not (case.path / "count.log").exists()
    assert not (case.path / f"{study}.study").exists()


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("is1_runs = 12", "is1_runs = 1", "is1_runs: expected at least initial_is1 = 2"),
        ("[objective]", "[reference]\nsample_time = 0.3\n[objective]", "whole number of samples"),
        ("2300.0]", "1900.0]\n'ctl.Kx' = 1.0", "no FMU parameter 'ctl.Kx'"),
    ],
)
def test_other_studies_that_cannot_be_played_are_refused(
    case: CaseFolder, old: str, new: str, said: str
) -> None:
    text = (case.path / "oob.toml").read_text(encoding="utf-8").replace("2300.0", "1900.0")
    old = old.replace("2300.0", "1900.0")
    (case.path / "other.toml").write_text(text.replace(old, new), encoding="utf-8")
    answer = case.gmfbo("tune other.toml --random-start")
    assert answer.code == 2
    assert said in answer.err
    assert not (case.path / "count.log").exists()
