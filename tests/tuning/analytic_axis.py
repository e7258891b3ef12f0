"""A plant in closed form: a position loop of second order, as a source of its own kind."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from gmfbo.errors import SimulationError
from gmfbo.recordings.recording import Recording, Trajectory
from gmfbo.tuning.study.study import Study

STUDY = """
name = "axis"
seed = {seed}
method = "{method}"
[is1]
ask_tell = true
[is2]
twin = "not-opened.toml"
[gains]
"ctl.Kp" = [30.0, 200.0]
"ctl.Kd" = [2.0, 10.0]
[reference]
step = 1.0
at = 0.05
horizon = 0.5
sample_time = 2e-3
[budget]
{budget}
"""


def write_study(
    folder: Path, *, method: str = "random", seed: int = 0, budget: str = "iterations = 4"
) -> Study:
    """Write a study file and read it back."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "axis.toml"
    path.write_text(STUDY.format(method=method, seed=seed, budget=budget), encoding="utf-8")
    return Study.read(path)


@dataclass
class AnalyticAxis:
    """J q'' = Kp (r - q) - Kd q', solved exactly; friction adds to Kd.

    Attributes
    ----------
    inertia : float
        J [kg m2].
    friction : float
        Viscous friction [N m s/rad].
    failing : frozenset of int
        Runs, counted from 1, that end in an error.
    """

    inertia: float = 0.12
    friction: float = 0.0
    failing: frozenset[int] = frozenset()
    name: str = "analytic axis"
    content_hash: str = ""
    seen: list[dict[str, float]] = field(default_factory=list)
    closed: bool = False

    def run(self, gains: Mapping[str, float], reference: Recording) -> Recording:
        """Answer a step of the reference."""
        self.seen.append(dict(gains))
        if len(self.seen) in self.failing:
            raise SimulationError("the axis lost its encoder")
        command = reference.signal("reference")
        start = reference.time[np.argmax(command != command[0])]
        t = np.maximum(reference.time - start, 0.0)
        stiffness, damping = gains["ctl.Kp"], gains["ctl.Kd"] + self.friction
        # Complex poles and real ones in one formula; equal poles have measure zero.
        root = np.sqrt(complex(damping**2 - 4.0 * self.inertia * stiffness))
        fast, slow = (-damping - root) / (2 * self.inertia), (-damping + root) / (2 * self.inertia)
        response = 1.0 + (fast * np.exp(slow * t) - slow * np.exp(fast * t)) / (slow - fast)
        position = command[0] + (command[-1] - command[0]) * response.real
        return Trajectory(
            time=reference.time,
            signals={"reference": command, "position": position},
            units={"reference": "rad", "position": "rad"},
            parameters=dict(gains),
        )

    def close(self) -> None:
        """Remember that somebody closed it."""
        self.closed = True
