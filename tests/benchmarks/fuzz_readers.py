"""Give every reader thousands of hostile files; may be stopped, and goes on where it was.

python tests/benchmarks/fuzz_readers.py [--seed 0] [--files 2000] [--only "CSV" ...] [--any-commit]
                                        [--state FILE.jsonl] [--out FILE]

Files are drawn by Hypothesis in batches of 250, each in a process of its own with 6 GiB of
address space. A batch is done or not: an interrupted campaign repeats the batch that it was in,
and batches that other code did are done again, unless `--any-commit` says that their readers are
the same. Each row names its commits. Files that are faults are kept beside the state.
"""

from __future__ import annotations

import argparse
import json
import math
import platform
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT))

from tests.fuzz.targets import TARGETS  # noqa: E402

BATCH = 250
LONGEST_S = 1800.0


def main() -> None:
    """Run what is not done yet, then print the table; exit status 1 where there was a fault."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--files", type=int, default=2000, help="of each kind")
    parser.add_argument("--any-commit", action="store_true", help="count batches of other code too")
    parser.add_argument("--only", nargs="+", choices=list(TARGETS), default=list(TARGETS))
    parser.add_argument("--state", type=Path, default=Path("fuzz_readers.jsonl"))
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    commit = _commit()
    done = _done(given.state, given.seed, None if given.any_commit else commit)
    for name in given.only:
        for batch in range(math.ceil(given.files / BATCH)):
            if (name, batch) not in {(entry["target"], entry["batch"]) for entry in done}:
                entry = _run(name, batch, given.seed, given.state.with_suffix(".faults"))
                entry["commit"] = commit
                done.append(entry)
                with given.state.open("a", encoding="utf-8") as state:
                    state.write(json.dumps(entry) + "\n")
    text, faults = table(done, given)
    print(text, end="")
    if given.out:
        given.out.write_text(text, encoding="utf-8")
    sys.exit(1 if faults else 0)


def _commit() -> str:
    """Commit of this checkout; it says so where files differ from it."""
    git = ["git", "-C", str(ROOT)]
    head, changes = (
        subprocess.run([*git, *words], capture_output=True, text=True, check=True).stdout.strip()
        for words in (
            ["rev-parse", "--short=7", "HEAD"],
            ["status", "--porcelain", "--untracked-files=no", "--", "gmfbo", "tests/fuzz"],
        )
    )
    return f"{head} with changes" if changes else head


def _done(state: Path, seed: int, commit: str | None) -> list[dict[str, Any]]:
    """Batches of a seed and a commit; without a commit the newest of each batch."""
    if not state.exists():
        return []
    entries = [json.loads(line) for line in state.read_text(encoding="utf-8").splitlines()]
    newest = {
        (entry["target"], entry["batch"]): entry
        for entry in entries
        if entry["seed"] == seed and commit in (None, entry["commit"])
    }
    return list(newest.values())


def _run(name: str, batch: int, seed: int, keep: Path) -> dict[str, Any]:
    """One batch in a process of its own, which a file may bring down."""
    command = [sys.executable, "-m", "tests.fuzz.batch", name, str(batch), str(seed), str(BATCH)]
    began = time.perf_counter()
    try:
        ran = subprocess.run(
            [*command, str(keep)],
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=False,
            timeout=LONGEST_S,
        )
        lines, status = ran.stdout.splitlines(), f"exit status {ran.returncode}"
        why = " ".join(ran.stderr.split())[-300:]
    except subprocess.TimeoutExpired:
        lines, status, why = [], f"no end within {LONGEST_S:.0f} s", ""
    entry: dict[str, Any] = {"target": name, "batch": batch, "seed": seed}
    if lines and lines[-1].startswith("{"):
        entry |= json.loads(lines[-1])
    else:
        fault = f"batch {batch} ended early: {status} {why}"
        entry |= {"tried": 0, "read": 0, "refused": {}, "ended_reader": 0, "faults": [fault],
                  "seconds": 0.0, "megabytes": 0.0}  # fmt: skip
    print(f"{name} {batch}: {time.perf_counter() - began:.0f} s, {len(entry['faults'])} faults")
    for fault in entry["faults"][:5]:
        print(f"    {fault}")
    sys.stdout.flush()
    return entry


def table(done: list[dict[str, Any]], given: argparse.Namespace) -> tuple[str, int]:
    """Result as text, and the number of faults."""
    files = f" --files {given.files}" if given.files != 2000 else ""
    only = "" if given.only == list(TARGETS) else " --only " + " ".join(map(repr, given.only))
    every = " --any-commit" if given.any_commit else ""
    lines = [
        f"command: python tests/benchmarks/fuzz_readers.py --seed {given.seed}{files}{only}{every}",
        f"Python {platform.python_version()}, {platform.system()} {platform.machine()}",
        "",
        f"{'reader':<16} {'files':>6} {'read':>6} {'refused':>8} {'reader ended':>13} "
        f"{'worst [s]':>10} {'worst [MB]':>11} {'faults':>7}  commit",
    ]
    faults: Counter[str] = Counter()
    for name in given.only:
        entries = [entry for entry in done if entry["target"] == name]
        if not entries:
            continue
        faults.update(f"{name}: {fault}" for entry in entries for fault in entry["faults"])
        lines.append(
            f"{name:<16} {_sum(entries, 'tried'):6d} {_sum(entries, 'read'):6d} "
            f"{sum(sum(entry['refused'].values()) for entry in entries):8d} "
            f"{_sum(entries, 'ended_reader'):13d} {_worst(entries, 'seconds'):10.2f} "
            f"{_worst(entries, 'megabytes'):11.0f} "
            f"{sum(len(entry['faults']) for entry in entries):7d}  "
            + ", ".join(dict.fromkeys(entry["commit"] for entry in entries))
        )
    lines += [
        "",
        "refused: by an error of gmfbo's own, one line. reader ended: of these, the reading",
        "process crashed, hung to its limit of time or met its limit of memory; the next file was",
        "read by a new one. worst: of one file; processor time and growth of memory, of the",
        "process that read it too.",
        f"limits: {_limits()}",
    ]
    lines += [f"FAULT ({count}): {fault}" for fault, count in faults.most_common(40)]
    return "\n".join([*lines, ""]), sum(faults.values())


def _limits() -> str:
    limits = {(t.seconds, t.megabytes) for t in TARGETS.values()}
    return "; ".join(f"{seconds:g} s and {size:.0f} MB" for seconds, size in sorted(limits))


def _sum(entries: list[dict[str, Any]], key: str) -> int:
    return sum(entry[key] for entry in entries)


def _worst(entries: list[dict[str, Any]], key: str) -> float:
    return float(max(entry[key] for entry in entries))


if __name__ == "__main__":
    main()
