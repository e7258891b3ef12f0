"""Baseline: sparse regression of the equation of motion on the recordings, with names.

Sequentially thresholded least squares (Brunton, Proctor, Kutz 2016) of the recorded command on
features of the recorded motion, differentiated after smoothing. No simulation, no noise model.
"""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.signal import savgol_filter

from tests.blind.truth import SAMPLE, Vector

THRESHOLD = 0.02
"""Share of the command's RMS below which a term is dropped."""

_SMOOTHED = 41
_ROUNDS = 10
_RIDGE = 1e-3
"""Of the mean square of a feature: terms that are almost alike share their part."""

_LINES = range(2, 40)
_ALWAYS = ("acceleration", "velocity")


def sparse_names(folder: Path) -> tuple[str, ...]:
    """Effects that the regression finds in a case.

    Parameters
    ----------
    folder : Path
        Of the case: twin.toml, rec0.csv, ...
    """
    twin = tomllib.loads((folder / "twin.toml").read_text(encoding="utf-8"))
    if not twin.get("ports"):
        return ()
    columns = [_columns(path) for path in sorted(folder.glob("rec*.csv"))]
    rotary = "axis" not in twin["name"] or "servo" in twin["name"]
    features = _features([q for q, _ in columns], [u for _, u in columns], rotary)
    target = np.concatenate([u[_SMOOTHED:-_SMOOTHED] for _, u in columns])
    return tuple(name for name in _thresholded(features, target) if name not in _ALWAYS)


def _columns(path: Path) -> tuple[Vector, Vector]:
    """Recorded position and command."""
    lines = [line for line in path.read_text("utf-8").splitlines() if not line.startswith("#")]
    names = [name.split(" ")[0] for name in lines[0].split(",")]
    table = np.array([line.split(",") for line in lines[1:]], dtype=float)
    command = next(k for k, n in enumerate(names) if n not in ("time", "reference", "position"))
    return table[:, names.index("position")], table[:, command]


def _features(
    positions: Sequence[Vector], commands: Sequence[Vector], rotary: bool
) -> dict[str, Vector]:
    parts: dict[str, list[Vector]] = {}
    speed = max(float(np.std(np.diff(q))) for q in positions) / SAMPLE
    for q_raw, u in zip(positions, commands, strict=True):
        q, v, a, jerk = (
            savgol_filter(q_raw, _SMOOTHED, 4, deriv=k, delta=SAMPLE) for k in range(4)
        )
        turn = np.tanh(v / (0.02 * speed))
        own = {
            "acceleration": a,
            "velocity": v,
            "constant_torque_offset": np.ones_like(q),
            "coulomb_friction": turn,
            "stribeck_friction": turn * np.exp(-((v / (0.1 * speed)) ** 2)),
            "quadratic_drag": v * np.abs(v),
            "load_dependent_friction": turn * np.abs(u),
            "elastic_return": q,
            "magnetic_saturation": savgol_filter(u, _SMOOTHED, 4) ** 3,
            "actuator_lag": jerk,
        }
        if rotary:
            own |= {"gravity_torque": np.sin(q), "gravity_torque cos": np.cos(q) - 1.0}
            for line in _LINES:
                own[f"cogging_torque {line}"] = np.sin(line * q)
                own[f"cogging_torque {line} cos"] = np.cos(line * q)
        for name, column in own.items():
            parts.setdefault(name, []).append(column[_SMOOTHED:-_SMOOTHED])
    return {name: np.concatenate(columns) for name, columns in parts.items()}


def _thresholded(features: dict[str, Vector], target: Vector) -> list[str]:
    kept, limit = list(features), THRESHOLD * float(np.sqrt(np.mean(target**2)))
    for _ in range(_ROUNDS):
        matrix = np.column_stack([features[name] for name in kept])
        scale = np.sqrt(np.mean(matrix**2, axis=0)) + 1e-300
        scaled = matrix / scale
        gram = scaled.T @ scaled + _RIDGE * len(target) * np.eye(len(kept))
        x = np.linalg.solve(gram, scaled.T @ target)
        large = [n for n, c in zip(kept, x, strict=True) if abs(c) > limit or n in _ALWAYS]
        if large == kept:
            break
        kept = large
    return list(dict.fromkeys(name.split(" ")[0] for name in kept))
