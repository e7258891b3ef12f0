"""A recording that follows another reference than was asked for is refused, with the reason."""

from __future__ import annotations

from tests.cases.case_folder import CaseFolder, needs_case

CASE = "24-recordings-contradict"
pytestmark = needs_case(CASE)


def test_another_reference_is_refused_and_taken_only_on_demand(case: CaseFolder) -> None:
    assert case.gmfbo("ask s.toml --random-start").code == 0
    degrees = case.gmfbo("tell s.toml deg_nounit.csv")
    assert degrees.code == 2
    assert "goes from 0 to 57.2958, but 0 to 1 rad was asked for" in degrees.err
    assert "degrees" in degrees.err
    half = case.gmfbo("tell s.toml halfstep.csv")
    assert half.code == 2
    assert "0.5 times as much" in half.err
    assert not list((case.path / "s.study/trials").glob("*5.h5"))
    assert case.gmfbo("tell s.toml halfstep.csv --anyway").code == 0
    assert list((case.path / "s.study/trials").glob("*5.h5"))
