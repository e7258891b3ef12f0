"""A bench as a program of its own, on the standard library alone: the axis of `AnalyticAxis`.

It trips above ctl.Kp = 150, as `tripping_axis` does.
"""

from __future__ import annotations

import cmath
import csv
import json
import sys
from collections.abc import Sequence
from pathlib import Path

INERTIA = 0.12  # [kg m2]
TRIPS_ABOVE = 150.0  # [N m/rad]


def main(words: Sequence[str]) -> int:
    """Answer the step of the reference at the gains in the arguments."""
    pairs = list(zip(words[::2], words[1::2], strict=True))
    option = dict(pairs)
    settings = [value.rpartition("=") for name, value in pairs if name == "--set"]
    gains = {name: float(value) for name, _, value in settings}
    request = json.loads(Path(option["--request"]).read_text(encoding="utf-8"))
    told = {"gains": gains, "reference": option["--reference"], "out": option["--out"]}
    if {name: request[name] for name in told} != told:
        print("arguments and request differ", file=sys.stderr)
        return 1
    if gains["ctl.Kp"] > TRIPS_ABOVE:
        print("drive enabled\nthe drive tripped", file=sys.stderr)
        return 3
    lines = Path(option["--reference"]).read_text(encoding="utf-8").splitlines()
    rows = list(csv.reader(line for line in lines if not line.startswith("#")))[1:]
    time, command = ([float(row[k]) for row in rows] for k in (0, 1))
    start = time[next(k for k, value in enumerate(command) if value != command[0])]
    out = [f"# {name} = {value!r}" for name, value in gains.items()]
    out.append("time [s],reference [rad],position [rad]")
    for t, r in zip(time, command, strict=True):
        position = command[-1] * answer(gains["ctl.Kp"], gains["ctl.Kd"], max(t - start, 0.0))
        out.append(f"{t!r},{r!r},{position!r}")
    Path(option["--out"]).write_text("\n".join(out) + "\n", encoding="utf-8")
    return 0


def answer(stiffness: float, damping: float, t: float) -> float:
    """Unit step response of J q'' = Kp (r - q) - Kd q' at a time after the step [s]."""
    root = cmath.sqrt(damping**2 - 4.0 * INERTIA * stiffness)
    fast, slow = (-damping - root) / (2.0 * INERTIA), (-damping + root) / (2.0 * INERTIA)
    decay = fast * cmath.exp(slow * t) - slow * cmath.exp(fast * t)
    return 1.0 + (decay / (slow - fast)).real


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
