"""A text that a package sets, and a twin file would lose, is refused by name."""

from __future__ import annotations

from tests.cases.case_folder import CaseFolder, needs_case

CASE = "04-ssp-string-parameter-dropped"
pytestmark = needs_case(CASE)


def test_the_parameter_is_named_and_nothing_is_written(case: CaseFolder) -> None:
    answer = case.gmfbo("import str.ssp --out x")
    assert answer.code == 2
    assert "parameter 'fileName' of 'axis' is of type String (gain2.txt)" in answer.err
    assert not list(case.path.glob("x/*.toml"))
