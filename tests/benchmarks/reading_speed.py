"""Time to read a plain CSV recording, beside that of an earlier commit of this checkout.

    python tests/benchmarks/reading_speed.py --before b197731

100,000 rows, three signals in the twin's units. Processes of both commits take turns, so that a
busy machine slows both; of each process the fastest of five readings counts, in processor time.
Exit status 1 where the median ratio is above 1.
"""

from __future__ import annotations

import argparse
import platform
import statistics
import subprocess
import sys
import tarfile
import tempfile
from io import BytesIO
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
RESULT = Path(__file__).parent / "results" / "reading_speed" / "reading_speed.txt"
ROWS = 100_000
TURNS = 5

READ = """
import sys, time
from pathlib import Path
sys.path.insert(0, sys.argv[1])
import gmfbo
from gmfbo import FmuTwin, Recording
assert gmfbo.__file__.startswith(sys.argv[1])
with FmuTwin(Path(sys.argv[1]) / "models/servo_axis.toml") as twin:
    seconds = []
    for _ in range(5):
        began = time.process_time()
        assert len(Recording.read(sys.argv[2], twin)) == int(sys.argv[3])
        seconds.append(time.process_time() - began)
print(min(seconds))
"""


def write_recording(path: Path) -> None:
    """A step response with noise, as a logger writes it."""
    time = np.arange(ROWS) * 1e-3
    noise = 1e-4 * np.random.default_rng(0).standard_normal(ROWS)
    table = np.column_stack([time, np.sin(time), np.sin(time - 0.01) + noise, np.cos(time)])
    header = "time [s],reference [rad],position [rad],torque_command [N.m]"
    np.savetxt(path, table, fmt=["%.4f", "%.6f", "%.6f", "%.5f"], delimiter=",", header=header,
               comments="")  # fmt: skip


def seconds(checkout: Path, recording: Path) -> float:
    """[s] Processor time of one reading, in a process of its own."""
    command = [sys.executable, "-P", "-c", READ, str(checkout), str(recording), str(ROWS)]
    # `-P` and the checkout's own folder first: an installed gmfbo is never the one that is timed.
    return float(subprocess.run(command, capture_output=True, text=True, check=True).stdout)


def main() -> None:
    """Time both commits in turns, and write what came out."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--before", default="b197731", help="commit to compare with")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name).resolve()
        earlier, recording = folder / "earlier", folder / "plain.csv"
        archive = ["git", "-C", str(ROOT), "archive", given.before, "gmfbo", "models"]
        content = subprocess.run(archive, capture_output=True, check=True).stdout
        with tarfile.open(fileobj=BytesIO(content)) as packed:
            packed.extractall(earlier, filter="data")
        write_recording(recording)
        pairs = [(seconds(earlier, recording), seconds(ROOT, recording)) for _ in range(TURNS)]
    ratio = statistics.median(now / before for before, now in pairs)
    lines = [
        f"command: python tests/benchmarks/reading_speed.py --before {given.before}",
        f"Python {platform.python_version()}, {platform.system()} {platform.machine()}",
        f"{ROWS} rows of CSV, three signals; processor time [s]",
        *(f"before {before:.3f}, now {now:.3f}" for before, now in pairs),
        f"median ratio {ratio:.2f}",
    ]
    text = "\n".join([*lines, ""])
    print(text, end="")
    RESULT.parent.mkdir(parents=True, exist_ok=True)
    RESULT.write_text(text, encoding="utf-8")
    sys.exit(1 if ratio > 1.0 else 0)


if __name__ == "__main__":
    main()
