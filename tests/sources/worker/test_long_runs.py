"""A short share of `tests/benchmarks/long_runs.py`, which makes 20,000 simulations."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from tests.foreign.fmus import find_foreign_fmu, write_own_axis, write_vendor_axis
from tests.long_runs import simulate_often

pytestmark = pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="memory and files are read from /proc"
)


def test_hundreds_of_runs_leave_no_memory_files_or_processes_behind(tmp_path: Path) -> None:
    """With an FMU by OpenModelica where its package is installed, else with ours alone."""
    own = write_own_axis(tmp_path)
    foreign = find_foreign_fmu("Mass_Damper") is not None
    twins = [write_vendor_axis(tmp_path) if foreign else own, own]
    first, *later = simulate_often(tmp_path, twins, runs=300, looks=2, warm_up=100)
    assert [look.runs for look in later] == [200, 300]
    for look in later:
        assert look.open_files == first.open_files
        assert look.processes == first.processes == 2 * len(twins)  # a keeper each
        assert look.total - first.total < 6e6  # an FMU by OpenModelica leaks 3 kB an instance
