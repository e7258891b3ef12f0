"""Trials of all three sources whose every number follows from the trial's own."""

from __future__ import annotations

import numpy as np

from gmfbo.recordings import Trajectory, Trial
from gmfbo.recordings.store.trial import SourceName

# Fields of a trial that are not arrays.
PROVENANCE = (
    "number", "source", "gains", "objective", "metrics", "status", "started", "seconds", "seed",
    "twin", "parent", "sigma_c", "accepted", "versions",
)  # fmt: skip


def example_trial(number: int, *, rows: int | None = None) -> Trial:
    """Trial `number`; of three in a row one each is of IS1, IS2 and IS3."""
    rng = np.random.default_rng(number)
    rows = int(rng.integers(50, 2000)) if rows is None else rows
    sources: tuple[SourceName, ...] = ("IS1", "IS2", "IS3")
    source = sources[(number - 1) % 3]
    corrected = source == "IS3"
    return Trial(
        number=number,
        source=source,
        gains={"ctl.Kp": 30.0 + number, "ctl.Kd": float(rng.random())},
        recording=Trajectory(
            time=0.1 + 1e-3 * np.arange(rows, dtype=np.float64),
            signals={
                "reference": np.where(np.arange(rows) < rows // 10, 0.0, 1.0),
                "position": rng.standard_normal(rows),
                "torque_command": rng.standard_normal(rows),
            },
            units={"reference": "rad", "position": "rad", "torque_command": "N.m"},
            name=f"run {number}",
            parameters={"mech.J": 0.12},
            schedules={"mot.kt": np.linspace(0.1, 0.2, rows)},
            use=(0.1, 0.9),
            seconds=0.004,
        ),
        objective=float(rng.standard_normal()),
        metrics={"overshoot": 3.25, "rise_time": 0.11},
        started="2026-01-02T03:04:05+00:00",
        seconds=0.25,
        seed=7,
        twin="c0ffee",
        parent=None if source == "IS1" else number - (1 if source == "IS2" else 2),
        sigma_c=0.015625 if corrected else None,
        accepted=number % 2 == 0 if corrected else None,
        uncorrected={"position": rng.standard_normal(rows)} if corrected else {},
        std={"position": rng.random(rows)} if corrected else {},
        versions={"gmfbo": "0.1.0"},
    )


def assert_same_trial(got: Trial, expected: Trial) -> None:
    """Every field of both is the same, to the last bit."""
    for name in PROVENANCE:
        assert getattr(got, name) == getattr(expected, name), name
    for name in ("units", "name", "parameters", "use", "start_time"):
        assert getattr(got.recording, name) == getattr(expected.recording, name), name
    for name in ("status", "message", "stopped_at", "seconds"):
        assert getattr(got.recording, name) == getattr(expected.recording, name), name
    np.testing.assert_array_equal(got.recording.time, expected.recording.time)
    for mine, theirs in (
        (got.recording.signals, expected.recording.signals),
        (got.recording.schedules, expected.recording.schedules),
        (got.uncorrected, expected.uncorrected),
        (got.std, expected.std),
    ):
        assert list(mine) == list(theirs)
        for name in mine:
            np.testing.assert_array_equal(mine[name], theirs[name])
