"""An FMU of FMI 3.0 all of whose variables are arrays."""

from __future__ import annotations

from tests.cases.case_folder import CaseFolder, needs_case

CASE = "15-arrays-only-fmi3"
pytestmark = needs_case(CASE)


def test_its_elements_are_variables_of_the_twin_file(case: CaseFolder) -> None:
    answer = case.gmfbo("inspect arrays3.fmu")
    for line in ("q_ref[1] = 0 q_ref[2] = 0", "outputs: 2 q[1] q[2]", "kp[1] = 40 kp[2] = 60"):
        assert line in answer.out
    twin = case.gmfbo("inspect --twin-file arrays3.fmu")
    assert twin.code == 0, twin.err
    for line in ('q_ref_1 = "q_ref[1]"', 'q_1 = "q[1]" q_2 = "q[2]"', '"kp[2]" = 60.0'):
        assert line in twin.out


def test_what_the_library_lacks_is_told(case: CaseFolder) -> None:
    """The library of this case has no functions; the FMU of tests/sources/kinds runs."""
    (case.path / "a.toml").write_text(
        'name = "a"\nfmu = "arrays3.fmu"\nstep = 1e-3\n[inputs]\nr = "q_ref[1]"\n'
        '[outputs]\nq = "q[1]"\n',
        encoding="utf-8",
    )
    answer = case.gmfbo("simulate a.toml --out s.csv")
    assert answer.code == 2
    assert "its library lacks fmi3DoStep" in answer.err
