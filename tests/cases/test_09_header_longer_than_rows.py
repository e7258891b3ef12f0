"""Oscilloscopes and LabVIEW: start and increment in the header, a comment column, unit words."""

from __future__ import annotations

import pytest

from tests.cases.case_folder import CaseFolder, needs_case

CASE = "09-header-longer-than-rows"
pytestmark = needs_case(CASE)

# Lines of `gmfbo columns`: name, unit, samples, smallest and largest value.
SHOWN = {
    "rigol.csv": ["X s 200 -0.1 0.099 time", "CH3 V 200 -0.30801 1.2069"],
    "rigol_seconds.csv": ["X s 200 0 0.199 time", "position deg 200 0 22.907 position"],
    "labview_lvm.txt": ["time s 200 0 0.199 time", "torque_command 200 -0.30801 1.2069"],
    "tek_labels_beside.csv": ["time s 200 -0.1 0.099 time", "CH1 V 200 0 0.3998"],
}


@pytest.mark.parametrize(("name", "lines"), SHOWN.items(), ids=SHOWN.keys())
def test_all_rows_are_read(case: CaseFolder, name: str, lines: list[str]) -> None:
    answer = case.gmfbo(f"columns ../servo.toml {name}")
    assert answer.code == 0, answer.err
    for line in lines:
        assert line in answer.out
