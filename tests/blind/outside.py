"""Mismatches that no effect of the catalogue describes, at each place of the loop."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tests.blind.hidden import FRICTION, Changes, Hidden, Rng, Setting


def _root(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    return lambda size: {"root_friction": size / float(np.sqrt(s.peak_speed))}


def _product(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    return lambda size: {"position_times_velocity": size / (s.travel * s.peak_speed)}


def _loose_spring(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    band = rng.uniform(0.2, 0.5) * s.travel
    return lambda size: {"spring": size / s.travel, "spring_dead_band": float(band)}


def _one_way(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    number, phase = rng.uniform(0.7, 1.5) * np.pi / s.travel, rng.uniform(0.0, 2.0 * np.pi)
    return lambda size: {
        "friction_positive": size,
        "friction_negative": 0.6 * size,
        "friction_wave": 0.9 * size,
        "friction_wave_number": float(number),
        "friction_wave_phase": phase,
        "friction_wave_one_way": 1.0,
    }


def _cubic_spring(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    return lambda size: {"cubic_spring": size / s.travel**3}


def _tightening(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    growth = rng.uniform(0.5, 1.5)
    return lambda size: {
        "friction_positive": size,
        "friction_negative": size,
        "friction_growth": float(growth),
    }


def _uneven(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    way = rng.choice([-1.0, 1.0])
    return lambda size: {"uneven": float(way * size)}


def _coarse(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    return lambda size: {"coarse": size}


def _bend(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    way = rng.choice([-1.0, 1.0])
    return lambda size: {"bend": float(way * size / s.travel)}


def _line_error(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    number = float(rng.integers(12, 60))
    return lambda size: {"line_error": size / number, "line_number": number}


def _play(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    return lambda size: {"play": size}


def _cubic_drag(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    return lambda size: {"cubic_drag": size / s.peak_speed**3}


def _rippled_drag(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    number = rng.uniform(2.0, 6.0) * np.pi / s.travel
    return lambda size: {
        "rippled_drag": size / s.peak_speed,
        "rippled_drag_number": float(number),
    }


def _sweep(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    start, rate = rng.uniform(2.0, 6.0), rng.uniform(3.0, 8.0)
    phase = rng.uniform(0.0, 2.0 * np.pi)
    return lambda size: {
        "sweep": size,
        "sweep_frequency": start,
        "sweep_rate": rate,
        "sweep_phase": phase,
    }


def _drive_play(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    return lambda size: {"drive_play": size}


def _of_torque(low: float, high: float) -> tuple[Callable[[Setting], float], ...]:
    return lambda s: low * s.torque, lambda s: high * s.torque


def _of(low: float, high: float) -> tuple[Callable[[Setting], float], ...]:
    return lambda s: low, lambda s: high


def _torque_law(make: Callable[[Setting, Rng], Callable[[float], Changes]], state: str) -> Hidden:
    low, high = _of_torque(1e-4, 0.3)
    return Hidden(make, "torque", ("plant",), (state,), low, high)


def _place_law(
    make: Callable[[Setting, Rng], Callable[[float], Changes]],
    port: str,
    path: str,
    state: str,
    least: float,
    most: float,
    rotary_only: bool = False,
) -> Hidden:
    low, high = _of(least, most)
    return Hidden(make, port, (path,), (state,), low, high, "", rotary_only)


OUTSIDE: dict[str, Hidden] = {
    "root_friction": _torque_law(_root, "velocity"),
    "position_times_velocity": _torque_law(_product, "position"),
    "spring_with_dead_band": _torque_law(_loose_spring, "position"),
    "one_way_friction": _torque_law(_one_way, "position"),
    "cubic_spring": _torque_law(_cubic_spring, "position"),
    "tightening_friction": _torque_law(_tightening, "velocity"),
    "uneven_drive": _place_law(_uneven, "command", "actuator", "command", 1e-3, 0.4),
    "coarse_drive": Hidden(
        _coarse,
        "command",
        ("actuator",),
        ("command",),
        lambda s: 1e-3 * s.peak_command,
        lambda s: 0.5 * s.peak_command,
    ),
    "bent_sensor": _place_law(_bend, "sensor", "sensor", "position", 1e-4, 0.15),
    "encoder_line_error": _place_law(
        _line_error, "sensor", "sensor", "position", 1e-4, 0.3, rotary_only=True
    ),
    "sensor_play": Hidden(
        _play,
        "sensor",
        ("sensor",),
        ("velocity", "position"),
        lambda s: s.machine.quantum,
        lambda s: 0.05 * s.travel,
    ),
}
"""By a name that no diagnosis gives."""

LATER_OUTSIDE: dict[str, Hidden] = {
    "cubic_drag": _torque_law(_cubic_drag, "velocity"),
    "rippled_drag": _torque_law(_rippled_drag, "position"),
    "sweeping_disturbance": _torque_law(_sweep, "time"),
    "drive_play": Hidden(
        _drive_play,
        "command",
        ("actuator",),
        ("command",),
        lambda s: 1e-4 * s.peak_command,
        lambda s: 0.3 * s.peak_command,
    ),
}
"""Laws that came after the seeds of the blind benchmark were drawn: only `tests.blind.draw` has
them, so that those seeds still give the same cases."""

LAWS_OUTSIDE = {**OUTSIDE, **LATER_OUTSIDE}
"""All of them."""

NEAREST: dict[str, frozenset[str]] = {
    "root_friction": FRICTION,
    "position_times_velocity": frozenset(),
    "spring_with_dead_band": frozenset({"elastic_return"}),
    "one_way_friction": FRICTION,
    "cubic_spring": frozenset({"elastic_return"}),
    "tightening_friction": FRICTION,
    "uneven_drive": frozenset(),
    "coarse_drive": frozenset({"actuator_dead_zone"}),
    "bent_sensor": frozenset(),
    "encoder_line_error": frozenset(),
    "sensor_play": frozenset(),
    "cubic_drag": frozenset({"quadratic_drag"}),
    "rippled_drag": frozenset(),
    "sweeping_disturbance": frozenset(),
    "drive_play": frozenset({"actuator_dead_zone"}),
}
"""Names that are part of such a mismatch: beside the verdict they are no false names."""
