"""Memory and open files over 20,000 simulations in one process that tunes.

Half of the runs step an FMU by OpenModelica (Mass_Damper of gemseo-fmu) under a controller of the
project, the others our linear axis under the same controller and by itself in FMI 3.0. Each run is
one of `FmuTwin.run`, which simulates twice: a probe of the start, and the run. Limits: 50 MB of
growth over all processes, no file more. Linux only.

    python tests/benchmarks/long_runs.py [--runs 20000]
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT))

from gmfbo.sources.fmu_file.models import models_folder  # noqa: E402
from tests.foreign.fmus import HOW, find_foreign_fmu, write_own_axis, write_vendor_axis  # noqa: E402
from tests.long_runs import Usage, simulate_often  # noqa: E402

RESULT = Path(__file__).parent / "results" / "long_runs" / "long_runs.txt"
LIMIT_BYTES = 50e6
LOOKS, WARM_UP = 20, 400
AXIS = """
name = "linear axis in FMI 3.0"
fmu = "FMU"
step = 1e-3
[inputs]
reference = "reference"
[outputs]
position = "position"
[gains]
"kp" = [40.0, 320.0]
"""


def line(seen: Usage) -> str:
    memory = f"{seen.tuner / 1e6:8.1f}{seen.workers / 1e6:9.1f}{seen.total / 1e6:8.1f}"
    return f"{seen.runs:6d}{memory}{seen.open_files:7d}{seen.processes:10d}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=20000)
    runs = parser.parse_args().runs
    if find_foreign_fmu("Mass_Damper") is None:
        print(f"no FMU by OpenModelica: {HOW}", file=sys.stderr)
        return 2
    began = time.perf_counter()
    lines = [f"$ python tests/benchmarks/long_runs.py --runs {runs}", ""]
    lines.append("  runs   tuner  workers   total  files   workers")
    lines.append("          [MB]     [MB]    [MB]")
    seen: list[Usage] = []
    with tempfile.TemporaryDirectory(prefix="gmfbo-long-") as name:
        folder = Path(name)
        third = folder / "fmi3.toml"
        third.write_text(AXIS.replace("FMU", str(models_folder() / "linear_axis_fmi3.fmu")))
        vendor = write_vendor_axis(folder)
        twins = [vendor, write_own_axis(folder), vendor, third]
        for look in simulate_often(folder, twins, runs, LOOKS, WARM_UP):
            seen.append(look)
            lines.append(line(look))
            print(lines[-1], flush=True)
    growth = max(look.total for look in seen) - seen[0].total
    files = max(look.open_files for look in seen) - seen[0].open_files
    seconds = time.perf_counter() - began
    lines += ["", f"largest growth {growth / 1e6:.1f} MB (limit 50), files +{files} (limit 0)"]
    lines.append(f"{seconds:.0f} s, {1e3 * seconds / runs:.1f} ms a run")
    print("\n".join(lines[-2:]))
    RESULT.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return int(growth > LIMIT_BYTES or files > 0)


if __name__ == "__main__":
    sys.exit(main())
