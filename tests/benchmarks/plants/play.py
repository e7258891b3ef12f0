"""Plays a plant as a program: the `command` of its study file.

    python play.py PLANT --set NAME=VALUE ... --request FILE --reference FILE --out FILE

Noise and friction of a run follow from its gains, so that the same gains give the same recording.
"""

from __future__ import annotations

import json
import sys
import zlib
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

from gmfbo.recordings.recording import Recording, Trajectory
from gmfbo.recordings.writing.writer import write_recording
from tests.benchmarks.plants.axis import PlantAxis
from tests.benchmarks.plants.catalogue import PLANTS


def main(arguments: list[str]) -> int:
    """Play one run; returns the exit status."""
    name, request = arguments[0], Path(arguments[arguments.index("--request") + 1])
    asked = json.loads(request.read_text(encoding="utf-8"))
    seed = zlib.crc32(json.dumps(asked["gains"], sort_keys=True).encode())
    axis = PlantAxis(PLANTS[name], seed)
    run = axis.run(asked["gains"], Recording.read(asked["reference"]))
    if isinstance(run, Trajectory) and run.status != "ok":
        print(run.message, file=sys.stderr)
        return 1
    write_recording(run, Path(asked["out"]))
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
