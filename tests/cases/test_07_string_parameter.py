"""A parameter of type String: the name of the file that holds the gain."""

from __future__ import annotations

import numpy as np

from gmfbo import Recording
from tests.cases.case_folder import CaseFolder, needs_case

CASE = "07-string-parameter"
pytestmark = needs_case(CASE)


def torque(case: CaseFolder, more: str = "") -> float:
    """[N.m] At the step of 1 rad, which is kp."""
    answer = case.gmfbo(f"simulate string.toml {more} --out s.csv")
    assert answer.code == 0, answer.err
    return float(np.abs(Recording.read(case.path / "s.csv").signal("torque")).max())


def test_the_text_chooses_the_gain(case: CaseFolder) -> None:
    own = torque(case)
    other = torque(case, "--set fileName=gain2.txt")
    assert other == 60.0
    assert own != other
    twin = case.path / "string.toml"
    text = twin.read_text(encoding="utf-8")
    line = '[parameters]\n"fileName" = "gain2.txt"\n'
    begins = next(part for part in text.splitlines() if part.startswith("[parameters]"))
    twin.write_text(text.replace(begins, line), encoding="utf-8")
    assert torque(case) == other
