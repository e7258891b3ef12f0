"""Sampled control laws, from their published equations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


def clipped(value: float, low: float, high: float) -> float:
    """The value, or the nearer limit."""
    return low if value < low else high if value > high else value


@dataclass
class Rate:
    """Filtered backward difference: d_k = (T_f d_{k-1} + x_k - x_{k-1}) / (T_f + T_s)."""

    filter_time: float
    sample: float
    value: float = 0.0
    before: float | None = None

    def next(self, x: float) -> float:
        """Rate at the next sample."""
        difference = 0.0 if self.before is None else x - self.before
        self.value = (self.filter_time * self.value + difference) / (self.filter_time + self.sample)
        self.before = x
        return self.value


@dataclass
class Integral:
    """Forward Euler with back-calculation (Astrom and Hagglund 2006, section 3.5)."""

    gain: float
    sample: float
    anti_windup: float = 0.0
    value: float = 0.0

    def next(self, error: float, excess: float) -> None:
        """Take the error of this sample, and by how much the limits cut the command."""
        rate = min(self.anti_windup, 1.0 / self.sample)
        self.value += self.sample * (self.gain * error - rate * excess)


class Pid:
    """Command of a PID law on the measurement.

    Parameters
    ----------
    gains : mapping of str to float
        `kp`, `ki`, `kd`; those that are missing are zero.
    sample, filter_time : float
        [s]
    limits : tuple of float
        Of the command.
    anti_windup : float
        [1/s]
    """

    def __init__(
        self,
        gains: Mapping[str, float],
        *,
        sample: float,
        limits: tuple[float, float],
        filter_time: float = 0.0,
        anti_windup: float = 0.0,
    ) -> None:
        self._kp, self._kd = gains.get("kp", 0.0), gains.get("kd", 0.0)
        self._rate = Rate(filter_time, sample)
        self._integral = Integral(gains.get("ki", 0.0), sample, anti_windup)
        self._limits = limits

    def next(self, reference: float, measured: float) -> float:
        """Command of the next sample."""
        error = reference - measured
        wanted = self._kp * error + self._integral.value + self._kd * self._rate.next(-measured)
        command = clipped(wanted, *self._limits)
        self._integral.next(error, wanted - command)
        return command


class Cascade:
    """Command of a position P law over a velocity PI law, with two feed-forward paths.

    Parameters
    ----------
    gains : mapping of str to float
        `kp`, `kv`, `ki`, `velocity_feedforward_gain`, `feedforward_gain`; missing ones are zero.
    sample, filter_time : float
        [s]
    limits : tuple of float
        Of the command.
    anti_windup : float
        [1/s]
    """

    def __init__(
        self,
        gains: Mapping[str, float],
        *,
        sample: float,
        limits: tuple[float, float],
        filter_time: float = 0.0,
        anti_windup: float = 0.0,
    ) -> None:
        self._kp, self._kv = gains["kp"], gains["kv"]
        self._forward = (
            gains.get("velocity_feedforward_gain", 0.0),
            gains.get("feedforward_gain", 0.0),
        )
        self._velocity, self._slope = Rate(filter_time, sample), Rate(0.0, sample)
        self._integral = Integral(gains.get("ki", 0.0), sample, anti_windup)
        self._limits = limits

    def next(self, reference: float, measured: float) -> float:
        """Command of the next sample."""
        slope = self._slope.next(reference)
        wanted_velocity = self._kp * (reference - measured) + self._forward[0] * slope
        error = wanted_velocity - self._velocity.next(measured)
        wanted = self._kv * error + self._integral.value + self._forward[1] * slope
        command = clipped(wanted, *self._limits)
        self._integral.next(error, wanted - command)
        return command
