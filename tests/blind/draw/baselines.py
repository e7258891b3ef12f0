"""Engines for `run` that stand for what an engineer would do without gmfbo's decision.

    python -m tests.blind.draw.run --out FOLDER --to stepwise.jsonl \
        --engine tests.blind.draw.baselines:stepwise

`stepwise` fits the whole library by output error, one law more at a time, for as long as Schwarz's
criterion falls. `sparse` regresses the equation of motion. `process` puts a Gaussian process over
position, velocity and acceleration on what the refitted twin leaves, and names nothing. The first
and the last get the package's own alignment, noise levels and simulators; what they lack is the
decision. Each is fitted to all recordings but one, which tells its errors.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.blind.refits import Errors, Refits
from tests.blind.sparse_regression import sparse_names


@dataclass(frozen=True)
class Said:
    """What a baseline said, in the words of diagnosis.json.

    Attributes
    ----------
    names : tuple of str
        Effects.
    errors : mapping of str to Errors
        By signal, on the recording held out; empty where the method has no model.
    simulations : int
        Runs of the twin.
    """

    names: tuple[str, ...] = ()
    errors: dict[str, Errors] | None = None
    simulations: int = 0

    def to_json(self) -> str:
        """Verdict, names, errors and cost."""
        content: dict[str, Any] = {
            "verdict": "missing_physics" if self.names else "parameters",
            "effects": [{"name": name} for name in self.names],
            "parameters": {},
            "fit": {"signals": {k: one.__dict__ for k, one in (self.errors or {}).items()}},
            "cost": {"simulations": self.simulations},
        }
        return json.dumps(content)


def sparse(twin: Path, recordings: Sequence[Path], jobs: int) -> Said:
    """Sparse regression (Brunton, Proctor, Kutz 2016); it has no simulation, so no errors."""
    return Said(sparse_names(twin.parent))


def stepwise(twin: Path, recordings: Sequence[Path], jobs: int) -> Said:
    """Stepwise fits over the library with Schwarz's criterion."""
    with Refits(twin.parent, recordings[-1].name) as refits:
        names, errors = refits.stepwise()
        return Said(names, errors, refits.simulations)


def process(twin: Path, recordings: Sequence[Path], jobs: int) -> Said:
    """Parameters alone, and a Gaussian process on what is left; no names."""
    with Refits(twin.parent, recordings[-1].name) as refits:
        return Said((), refits.process(), refits.simulations)
