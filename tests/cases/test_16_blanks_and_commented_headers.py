"""Blanks between cells, a header behind #, and no header at all."""

from __future__ import annotations

import pytest

from tests.cases.case_folder import CaseFolder, needs_case

CASE = "16-blanks-and-commented-headers"
pytestmark = needs_case(CASE)


@pytest.mark.parametrize("name", ["spaces.txt", "savetxt.csv", "savetxt.txt"])
def test_the_header_is_found(case: CaseFolder, name: str) -> None:
    answer = case.gmfbo(f"columns ../servo.toml {name}")
    assert answer.code == 0, answer.err
    assert "4 columns, 200 rows" in answer.out
    for line in ("time 200 0 0.199 time", "position 200 0 0.3998 position"):
        assert line in answer.out


def test_columns_without_a_header_are_named_by_their_places(case: CaseFolder) -> None:
    answer = case.gmfbo("columns ../servo.toml halsampler.txt")
    assert answer.code == 0, answer.err
    assert "column 1 200 0 199" in answer.out
    assert "column 4 200 -0.30801 1.2069" in answer.out
    assert "--sample-time 0.001" in answer.out
    (case.path / "servo.toml").write_text(
        (case.path / "../servo.toml").read_text(encoding="utf-8")
        + '[columns]\ntime = { sample_time = 1e-3 }\nreference = "column 2"\n'
        'position = "column 3"\ntorque_command = "column 4"\n',
        encoding="utf-8",
    )
    told = case.gmfbo("simulate servo.toml --reference halsampler.txt --out s.csv")
    assert told.code == 0, told.err
    assert "200 rows, 0.199 s" in told.out


def test_the_preset_of_halsampler_knows_the_sample_number(case: CaseFolder) -> None:
    answer = case.gmfbo("columns ../servo.toml halsampler.txt --preset halsampler")
    assert answer.code == 0, answer.err
    assert "preset halsampler, by https://linuxcnc.org/" in answer.out
    assert "column 1 200 0 199 time" in answer.out
