"""Limits within which a drive may be moved, and how far a sampled motion goes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import InputError, did_you_mean
from gmfbo.files.toml_text import parse_toml, read_toml_text

Column = NDArray[np.float64]

_RATES = ("velocity", "acceleration", "jerk", "torque", "duration")
_REQUIRED = ("position", "velocity", "acceleration", "duration")
_EXAMPLE = "position = [-0.5, 0.5]"
_ROUNDING = 1e-9  # share that numbers may be off when they are differenced


@dataclass(frozen=True)
class PlayLimits:
    """Limits of a motion, in SI units.

    Attributes
    ----------
    low, high : float
        [rad or m] Of the position.
    velocity : float
        [rad/s or m/s]
    acceleration : float
        [rad/s2 or m/s2]
    duration : float
        [s] Of the whole file.
    jerk : float
        [rad/s3 or m/s3] Infinite where none is given.
    torque : float
        [unit of the state command] Infinite where none is given.
    """

    low: float
    high: float
    velocity: float
    acceleration: float
    duration: float
    jerk: float = math.inf
    torque: float = math.inf

    def rate(self, name: str) -> float:
        """Limit of the velocity, the acceleration or the jerk.

        Parameters
        ----------
        name : str
            One of the three.
        """
        return {
            "velocity": self.velocity,
            "acceleration": self.acceleration,
            "jerk": self.jerk,
        }[name]

    @classmethod
    def read(cls, path: Path) -> PlayLimits:
        """Read a limits file.

        Parameters
        ----------
        path : Path
            TOML with position, velocity, acceleration, duration, and maybe jerk and torque.

        Raises
        ------
        InputError
            The file cannot be read, lacks a limit, or holds an invalid one.
        """
        try:
            content = parse_toml(read_toml_text(path))
        except OSError as error:
            raise InputError(
                f"no limits file at '{path}' ({error.strerror or error}); expected TOML such as "
                f"{_EXAMPLE}"
            ) from None
        except ValueError as error:
            raise InputError(f"{path.name}: not valid TOML: {error}") from None
        return cls.from_mapping(content, path.name)

    @classmethod
    def from_mapping(cls, content: Mapping[str, Any], label: str) -> PlayLimits:
        """Take limits from the content of a file.

        Parameters
        ----------
        content : mapping
            Limits by name.
        label : str
            Name of the file, for messages.

        Raises
        ------
        InputError
            A limit is missing, unknown or invalid.
        """
        for name in content:
            if name not in ("position", *_RATES):
                raise InputError(
                    f"{label}: no limit '{name}'{did_you_mean(name, ('position', *_RATES))}"
                )
        missing = [name for name in _REQUIRED if name not in content]
        if missing:
            raise InputError(
                f"{label}: expected the limits {', '.join(_REQUIRED)} (jerk and torque may be left "
                f"out), '{missing[0]}' is missing; add it"
            )
        low, high = _range(content["position"], label)
        given = {name: _positive(content[name], name, label) for name in _RATES if name in content}
        return cls(low=low, high=high, **given)


def _range(value: Any, label: str) -> tuple[float, float]:
    if (
        isinstance(value, list)
        and len(value) == 2
        and all(_is_number(end) for end in value)
        and value[0] < value[1]
    ):
        return float(value[0]), float(value[1])
    raise InputError(f"{label}: expected position = [low, high] such as {_EXAMPLE}, got {value!r}")


def _positive(value: Any, name: str, label: str) -> float:
    if _is_number(value) and value > 0.0:
        return float(value)
    raise InputError(f"{label}: expected {name} to be a number above zero, got {value!r}")


def _is_number(value: Any) -> bool:
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return is_number and math.isfinite(value)


def largest_rates(values: Column, spacing: float) -> dict[str, float]:
    """Largest velocity, acceleration and jerk of a sampled motion, by finite differences.

    Parameters
    ----------
    values : ndarray, shape (rows,)
        [rad or m]
    spacing : float
        [s] Between rows.
    """
    return {
        name: float(np.abs(np.diff(values, order)).max(initial=0.0)) / spacing**order
        for order, name in enumerate(("velocity", "acceleration", "jerk"), start=1)
    }


def shrunk(values: Column, limits: PlayLimits, start: float, spacing: float) -> Column:
    """Shrink a motion about its start until no sample is beyond a limit."""
    shares = [1.0]
    for name, largest in largest_rates(values, spacing).items():
        shares.append(limits.rate(name) / largest if largest > 0.0 else 1.0)
    above, below = float(values.max()) - start, start - float(values.min())
    least = _ROUNDING * (limits.high - limits.low)  # a motion may begin at the end of its range
    shares.append((limits.high - start) / above if above > least else 1.0)
    shares.append((start - limits.low) / below if below > least else 1.0)
    share = min(shares)
    if share < 1.0:
        share *= 1.0 - _ROUNDING
    return np.asarray(start + share * (values - start))
