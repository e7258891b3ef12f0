"""Layouts of MATLAB, Simulink, ControlDesk and HDF5 tables, each with three signals."""

from __future__ import annotations

import pytest

from tests.cases.case_folder import CaseFolder, needs_case

CASE = "08-matlab-layouts"
pytestmark = needs_case(CASE)

RANGES = {
    "reference": "-0.4 0.4",
    "position": "-0.39982 0.39982",
    "torque_command": "-0.35586 1.2069",
}
NAMED = ["simulink_struct.mat", "tout_named.mat", "ts_struct.mat", "compound.h5"]
UNNAMED = {
    "simulink_array.mat": "log(:,{})",
    "simulink_tout.mat": "yout(:,{})",
}


@pytest.mark.parametrize("name", NAMED)
def test_named_signals_are_found_with_all_their_rows(case: CaseFolder, name: str) -> None:
    answer = case.gmfbo(f"columns ../servo.toml {name}")
    assert answer.code == 0, answer.err
    for signal, ends in RANGES.items():
        unit = "rad " if name == "ts_struct.mat" else ""
        assert f"{signal} {unit}1000 {ends} {signal}" in answer.out
    assert "0.999 time" in answer.out


@pytest.mark.parametrize(("name", "column"), UNNAMED.items(), ids=UNNAMED.keys())
def test_a_matrix_without_names_is_mapped_on_the_command_line(
    case: CaseFolder, name: str, column: str
) -> None:
    first = 2 if name == "simulink_array.mat" else 1
    sets = " ".join(f"--set {signal}={column.format(first + k)}" for k, signal in enumerate(RANGES))
    answer = case.gmfbo(f"columns ../servo.toml {name} {sets} --save m.toml")
    assert answer.code == 0, answer.err
    for k, (signal, ends) in enumerate(RANGES.items()):
        assert f"{column.format(first + k)} 1000 {ends} {signal}" in answer.out
    assert "0.999 time" in answer.out
    twin = case.path / "twin.toml"
    text = (case.path / "../servo.toml").read_text(encoding="utf-8")
    twin.write_text('columns = "m.toml"\n' + text, encoding="utf-8")
    assert "1000 rows" in case.gmfbo(f"simulate twin.toml --reference {name} --out s.csv").out


def test_control_desk_names_are_paths(case: CaseFolder) -> None:
    answer = case.gmfbo("columns ../servo.toml controldesk.mat")
    assert answer.code == 0, answer.err
    for line in (
        "Model Root/ref/Out1 1000 -0.4 0.4",
        "position 1000 -0.39982 0.39982 position",
        "torque_command 1000 -0.35586 1.2069 torque_command",
        "time s 1000 0 0.999 time",
    ):
        assert line in answer.out
