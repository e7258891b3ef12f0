"""Location of the mismatch, and its shape where it has no name."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

SignalPath = Literal["controller", "actuator", "plant", "transmission", "sensor"]


class TimeWindow(NamedTuple):
    """A stretch of one recording.

    Attributes
    ----------
    recording : str
        Its name.
    start, end : float
        [s] In the recording's own time.
    """

    recording: str
    start: float
    end: float


@dataclass(frozen=True)
class Location:
    """Place of the mismatch between twin and recordings.

    Attributes
    ----------
    signal_path : {"controller", "actuator", "plant", "transmission", "sensor"} or None
        Part of the loop; None where nothing is missing.
    region : str
        State in which it acts, in plain words, such as "where the velocity changes sign".
    times : tuple of TimeWindow
        Stretches in which it shows most.
    """

    signal_path: SignalPath | None
    region: str = ""
    times: tuple[TimeWindow, ...] = ()


@dataclass(frozen=True)
class Shape:
    """Inferred signal of a mismatch against the state, or the time, that it depends on.

    Attributes
    ----------
    port : str
        Port at which it acts.
    against : str
        State on the x axis, or `time`.
    x : tuple of float, n values
        [unit_x] The state, rising.
    y : tuple of float, n values
        [unit_y] What is missing at the port.
    y_low, y_high : tuple of float, n values
        [unit_y] Ends of its 95 % band.
    unit_x, unit_y : str
        Units.
    law : str
        Named effect that stands for it; empty where no law does.
    law_x : tuple of float, m values
        [unit_x] The state along the law, rising.
    law_y : tuple of float, m values
        [unit_y] Torque of all named laws at the port.
    """

    port: str
    against: str
    x: tuple[float, ...]
    y: tuple[float, ...]
    y_low: tuple[float, ...]
    y_high: tuple[float, ...]
    unit_x: str
    unit_y: str
    law: str = ""
    law_x: tuple[float, ...] = ()
    law_y: tuple[float, ...] = ()

    @property
    def largest(self) -> float:
        """[unit_y] Largest size whose band holds one sign alone; NaN where there is none."""
        bands = zip(self.y, self.y_low, self.y_high, strict=True)
        return max((abs(y) for y, low, high in bands if low * high > 0.0), default=math.nan)
