"""Study folders as a tuner writes them, of second-order step responses, in a blink."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gmfbo.objective.metrics import step_metrics
from gmfbo.recordings import Trajectory, Trial
from gmfbo.recordings.recording import Status
from gmfbo.recordings.store.study_folder import StudyStore
from gmfbo.recordings.store.trial import SourceName

Array = NDArray[np.float64]

STUDY = """
name = "{name}"
method = "gmfbo_paper"
[is1]
twin = "plant.toml"
[is2]
twin = "twin.toml"
[gains]
{gains}
[objective]
normalise = {twin_runs}
[budget]
initial_is1 = 2
initial_is2 = {twin_runs}
iterations = 4
"""

TIME = np.linspace(0.0, 1.1, 551)
REFERENCE = np.where(TIME < 0.1, 0.0, 1.0)
UNITS = {"position": "rad", "reference": "rad", "torque_command": "N.m"}
BOX = {"ctl.Kp": (100.0, 900.0), "ctl.Kd": (4.0, 60.0), "ctl.Ki": (0.1, 1.0)}


def response(stiffness: float, damping: float) -> Array:
    """Step response of q'' + damping q' + stiffness q = stiffness r, shape (n,)."""
    omega, zeta = np.sqrt(stiffness), damping / (2.0 * np.sqrt(stiffness))
    since = np.maximum(TIME - 0.1, 0.0)
    root = np.sqrt(complex(zeta**2 - 1.0)) or 1e-9
    decay = np.exp(-zeta * omega * since)
    swing = np.cosh(omega * root * since) + zeta / root * np.sinh(omega * root * since)
    return np.asarray((1.0 - decay * swing).real)


class ExampleStudy:
    """A study folder that is written run by run.

    Parameters
    ----------
    folder : Path
        `NAME.study`, to be made.
    gains : int
        How many are tuned, of `BOX`.
    name : str
        Of the study.
    twin_runs : int
        Initial ones.
    """

    def __init__(
        self, folder: Path, *, gains: int = 2, name: str = "example", twin_runs: int = 8
    ) -> None:
        self.box = dict(list(BOX.items())[:gains])
        ranges = "\n".join(f'"{name}" = [{a}, {b}]' for name, (a, b) in self.box.items())
        text = STUDY.format(name=name, gains=ranges, twin_runs=twin_runs)
        self.store, self._rng = StudyStore.create(folder, text), np.random.default_rng(1)
        self.number, self.twin = 0, "twin 0"

    def gains(self) -> dict[str, float]:
        """Gains somewhere in the box."""
        return {n: float(self._rng.uniform(a, b)) for n, (a, b) in self.box.items()}

    def trial(
        self,
        source: SourceName,
        gains: Mapping[str, float],
        *,
        parent: int | None = None,
        accepted: bool | None = None,
        status: Status = "ok",
        late_error: float | None = None,
    ) -> Trial:
        """Write a run and return it; the twin is softer than the axis, once corrected hardly."""
        self.number += 1
        soft = {"IS1": 1.0, "IS2": 0.6, "IS3": 0.98}[source]
        stiffness, damping = gains["ctl.Kp"], gains.get("ctl.Kd", 20.0)
        position = response(soft * stiffness, damping)
        signals = {"position": position}
        if source != "IS3":
            signals |= {
                "reference": REFERENCE,
                "torque_command": stiffness * (REFERENCE - position),
            }
        found = step_metrics(TIME, position, step_time=0.1, horizon=1.0)
        metrics = {name: float(value) for name, value in found.items()}
        corrected = source == "IS3"
        trial = Trial(
            number=self.number,
            source=source,
            gains=dict(gains),
            recording=Trajectory(
                TIME, signals, units=UNITS, status=status
            ),
            objective=4.0 * metrics["rise_time"] + metrics["settling_time"] - 1.0,
            metrics=metrics,
            status=status,
            started=f"2026-01-02T03:04:{self.number:02d}.000+00:00",
            seconds=0.25,
            twin="plant" if source == "IS1" else self.twin,
            parent=parent,
            sigma_c=0.01 if corrected else None,
            accepted=accepted,
            uncorrected={"position": response(0.6 * stiffness, damping)} if corrected else {},
            std={"position": np.full(TIME.size, 0.01)} if corrected else {},
            late_error=late_error,
        )  # fmt: skip
        self.store.write_trial(trial)
        return trial

    def real(
        self,
        gains: Mapping[str, float],
        mismatch: float | None,
        status: Status = "ok",
        late_error: float | None = None,
    ) -> Trial:
        """A real run, with the twin's beside it and two corrected ones around it."""
        self.store.log("ask", number=self.number + 1, source="IS1", gains=gains, mismatch=mismatch,
                       note="")  # fmt: skip
        real = self.trial("IS1", gains, status=status, late_error=late_error)
        self.store.log("tell", number=real.number, gains=gains, file="", sha256="")
        self.trial("IS2", gains, parent=real.number)
        self.store.log("correction", parent=real.number, held_out_error=0.001 * real.number,
                       uncorrected_error=0.1, note="")  # fmt: skip
        for accepted in (True, False):
            near = {name: 1.01 * value for name, value in gains.items()}
            self.trial("IS3", near, parent=real.number, accepted=accepted)
        return real

    def end(self, gains: Mapping[str, float]) -> None:
        """The recommendation with which a study ends."""
        self.store.log("recommendation", gains=gains, mean=-0.9, std=0.05)


def write_example_study(folder: Path, *, gains: int = 2, name: str = "example") -> Path:
    """A study that came to its end, and whose twin was corrected on the way.

    Asked for by the method were 3 of its 5 real runs, and one run of the twin.

    Parameters
    ----------
    folder : Path
        Where `NAME.study` is made.
    gains : int
        How many are tuned.
    name : str
        Of the study.
    """
    path = folder / f"{name}.study"
    made = ExampleStudy(path, gains=gains, name=name)
    with made.store as store:
        for _ in range(8):
            made.trial("IS2", made.gains())
        slow = {**made.gains(), "ctl.Kp": 150.0}
        made.real(slow, None)
        made.real({**made.gains(), "ctl.Kp": 420.0}, None)
        made.real({**made.gains(), "ctl.Kp": 880.0}, 1.5)
        store.log("ask", number=made.number + 1, source="IS2", gains=slow, mismatch=1.25, note="")
        made.trial("IS2", slow)
        made.twin = "twin 1"
        store.log("twin_version", version=1, after=made.number - 4, twin=made.twin,
                  reason="friction of 0.4 N m <found> by diagnosis",
                  learned=[{"name": "mech.J", "unit": "kg.m2", "before": 0.12, "after": 0.148,
                            "low": 0.142, "high": 0.155}])  # fmt: skip
        for _ in range(5):
            made.trial("IS2", made.gains())
        made.real({**made.gains(), "ctl.Kp": 840.0}, 0.5, "unsafe")
        best = made.real({**made.gains(), "ctl.Kp": 860.0, "ctl.Kd": 50.0}, 0.125)
        made.end(best.gains)
    return path
