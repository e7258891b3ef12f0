"""Diagnose the EMPS axis as one recording: whole, by halves, and in six pieces of 8 to 12 s.

    GMFBO_DATA=FOLDER python tests/benchmarks/emps_pieces.py [PIECE ...] \\
        > tests/benchmarks/results/emps_diagnosis/emps_pieces.txt

What the rig's authors publish is friction that differs by direction, or Coulomb friction with a
constant force (Janot, Gautier, Brunot 2019). A piece counts as right where a friction law is named
together with an asymmetry or a constant force. The whole recording was looked at while the
diagnosis was developed: these figures are no evidence for it.
"""

from __future__ import annotations

import os
import sys
from dataclasses import replace
from pathlib import Path

from gmfbo import FmuTwin, Recording, diagnose, models_folder
from gmfbo.diagnosis import Diagnosis

PIECES = {
    "whole": (0.0, 99.0),
    "half 1": (0.0, 12.4335),
    "half 1, scored on half 2": (0.0, 12.4335),
    "half 2": (12.471, 99.0),
    "0-8 s": (0.0, 8.0),
    "4-14 s": (4.0, 14.0),
    "6.2-14.5 s": (6.231, 14.5),
    "8-17 s": (8.0, 17.0),
    "12.5-24 s": (12.471, 24.0),
    "15-24.9 s": (15.0, 24.9),
}
SCORED_ON = {"half 1, scored on half 2": "half 2"}
FRICTION = {"coulomb_friction", "stribeck_friction", "presliding_friction", "asymmetric_friction"}
ONE_SIDED = {"asymmetric_friction", "constant_torque_offset", "elastic_return"}


def piece(whole: Recording, first: float, last: float) -> Recording:
    """Rows between two times [s], from zero on."""
    rows = (whole.time > first - 5e-4) & (whole.time < last - 5e-4)
    signals = {name: column[rows] for name, column in whole.signals.items()}
    time = whole.time[rows] - whole.time[rows][0]
    return replace(whole, name=f"{first:g} s", time=time, signals=signals)


def is_right(diagnosis: Diagnosis) -> bool:
    """Whether friction is named, and what makes it differ by direction."""
    names = {name for effect in diagnosis.effects for name in effect.set}
    return bool(names & FRICTION) and bool(names & ONE_SIDED)


def main(chosen: list[str]) -> int:
    """Diagnose each piece and print names, errors and cost."""
    if "GMFBO_DATA" not in os.environ:
        print("set GMFBO_DATA to the folder that holds emps/DATA_EMPS.mat", file=sys.stderr)
        return 2
    twin = FmuTwin(models_folder() / "emps.toml")
    whole = Recording.read(Path(os.environ["GMFBO_DATA"]) / "emps" / "DATA_EMPS.mat", twin)
    print("piece | right | named (probability of the set) | error of the voltage, held out | cost")
    for name in chosen or PIECES:
        unseen = [piece(whole, *PIECES[SCORED_ON[name]])] if name in SCORED_ON else None
        found = diagnose(twin, [piece(whole, *PIECES[name])], unseen, seed=0)
        named = ", ".join(f"{'|'.join(e.set)} {e.set_probability:.2f}" for e in found.effects)
        fit = found.fit.signals["drive_voltage"]
        print(
            f"{name} | {'yes' if is_right(found) else 'no'} | {found.verdict}: {named} | "
            f"{fit.parameters_only:.2%} -> {fit.augmented:.2%}, noise {fit.noise_floor:.2%} | "
            f"{found.cost.simulations} simulations, {found.cost.seconds:.0f} s",
            flush=True,
        )
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
