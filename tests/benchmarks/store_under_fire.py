"""The store under fire: kills, full disks, limits of file size, damaged files.

python tests/benchmarks/store_under_fire.py [--kills 200] [--disks 20] [--damaged 200] [--seed 0]
                                            [--out FILE]
"""

from __future__ import annotations

import argparse
import platform
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT))

from tests.recordings.repair.damage_rounds import KINDS, DamageReport, run_damage_rounds  # noqa: E402
from tests.recordings.store.full_disk_rounds import FullDiskReport, run_full_disk_rounds  # noqa: E402
from tests.recordings.store.kill_rounds import KillReport, run_kill_rounds  # noqa: E402


def kill_lines(report: KillReport) -> list[str]:
    """What the kills did."""
    return [
        "killed writers",
        f"  writers killed by SIGKILL                            {report.kills:6d}",
        f"  of them in the middle of a file (unfinished left)    {report.unfinished_files:6d}",
        f"  of them in the middle of an event line (torn line)   {report.torn_lines:6d}",
        f"  trials stored                                        {report.stored:6d}",
        f"  events acknowledged                                  {report.asked:6d}",
        f"  acknowledged trials or events lost                   {len(report.lost):6d}",
    ]


def disk_lines(report: FullDiskReport) -> list[str]:
    """What full disks did."""
    return [
        "full disks (tmpfs of 0.2 to 2 MB) and limits of file size",
        f"  writers refused by a full disk                       {report.disks:6d}",
        f"  writers refused by a limit of file size              {report.limits:6d}",
        f"  trials stored before                                 {report.stored:6d}",
        f"  refusals that were not one clear line                {len(report.unclear):6d}",
        f"  stored trials lost, unfinished files left            {len(report.lost):6d}",
    ]


def damage_lines(report: DamageReport) -> list[str]:
    """What damaged files gave."""
    rows = [
        f"  {kind:<20} {report.damaged[kind]:8d} {report.mended[kind]:12d} {report.lost[kind]:12d}"
        for kind in KINDS
    ]
    return [
        f"damaged files, {report.rounds} studies of six trials, one to three files damaged in each",
        f"  {'trial files':<20} {'damaged':>8} {'whole again':>12} {'set aside':>12}",
        *rows,
        f"  set aside, with signals saved as a recording         {report.saved:6d}",
        f"  event lines with one wrong bit, mended               {report.lines:6d} "
        f"{report.lines_mended:6d}",
        f"  read differently from what was written, or lost whole{len(report.wrong):6d}",
    ]


@contextmanager
def timed(text: list[str]) -> Iterator[None]:
    """Add the seconds of a part."""
    began = time.perf_counter()
    yield
    text += [f"  seconds                                              {_since(began):6.0f}", ""]
    print("\n".join(text[-12:]), flush=True)


def _since(began: float) -> float:
    return time.perf_counter() - began


def main() -> None:
    """Run all parts; exit status 1 where anything was lost or unclear."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--disks", type=int, default=20)
    parser.add_argument("--damaged", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    text = [
        "command: python tests/benchmarks/store_under_fire.py "
        f"--kills {given.kills} --disks {given.disks} --damaged {given.damaged} "
        f"--seed {given.seed}",
        f"Python {platform.python_version()}, {platform.system()} {platform.machine()}",
        "",
    ]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        with timed(text):
            killed = run_kill_rounds(folder / "killed.study", given.kills, given.seed)
            text += kill_lines(killed)
        with timed(text):
            full = run_full_disk_rounds(folder / "disks", given.disks, given.seed)
            text += disk_lines(full)
        with timed(text):
            damaged = run_damage_rounds(folder, given.damaged, given.seed)
            text += damage_lines(damaged)
    faults = [*killed.lost, *full.unclear, *full.lost, *damaged.wrong]
    text += [f"FAULT: {fault}" for fault in faults] or ["no fault"]
    if given.out:
        given.out.write_text("\n".join([*text, ""]), encoding="utf-8")
    print(text[-1])
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
