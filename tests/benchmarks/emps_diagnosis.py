"""Diagnose the EMPS twin on the first half of its recording, score the second.

    GMFBO_DATA=FOLDER python tests/benchmarks/emps_diagnosis.py \\
        > tests/benchmarks/results/emps_diagnosis/emps_diagnosis.txt

Runs `notebooks/03_find_the_missing_physics.py`, which prints what it found and asserts it.

Source of the recording and of the published values: Janot, Gautier, Brunot (2019), "Data set
and reference models of EMPS".
"""

from __future__ import annotations

import os
import runpy
import sys
from pathlib import Path

NOTEBOOK = Path(__file__).resolve().parents[2] / "notebooks/03_find_the_missing_physics.py"


def main() -> int:
    """Run the notebook, which prints what it found, and print the refitted parameters."""
    if "GMFBO_DATA" not in os.environ:
        print("set GMFBO_DATA to the folder that holds emps/DATA_EMPS.mat", file=sys.stderr)
        return 2
    found = runpy.run_path(str(NOTEBOOK))
    diagnosis = found["diagnosis"]
    for name, parameter in diagnosis.parameters.items():
        interval = f"[{parameter.low:.2f}, {parameter.high:.2f}] {parameter.unit}"
        print(f"{name:<20} {parameter.value:9.2f} {interval}")
    print(f"{diagnosis.cost.simulations} simulations, {diagnosis.cost.seconds:.0f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
