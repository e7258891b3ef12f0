"""True values of a hidden effect in the words of a diagnosis: to judge numbers, not names.

Only where the law of the catalogue and that of the true plant share a parameter. Pairs of sine and
cosine amplitude stand as they are; their size is judged together.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from tests.blind.hidden import Changes

Values = dict[str, float]


def true_values(name: str, changes: Changes, known: Mapping[str, float]) -> Values:
    """Parameters by the names under which a diagnosis reports them.

    Parameters
    ----------
    name : str
        Of the effect.
    changes : mapping of str to float
        Of the true plant.
    known : mapping of str to float
        The plant without the effect.
    """
    reader = _READERS.get(name)
    return {} if reader is None else {k: float(v) for k, v in reader(changes, known).items()}


def _same(**names: str) -> Callable[[Changes, Mapping[str, float]], Values]:
    return lambda c, known: {said: abs(c[own]) for said, own in names.items()}


def _wave(size: float, phase: float, line: int | None = None) -> Values:
    """a sin(x + phase) as a sine and a cosine amplitude."""
    end = "" if line is None else f"_{line}"
    return {f"sine{end}": size * np.cos(phase), f"cosine{end}": size * np.sin(phase)}


def _stribeck(c: Changes, known: Mapping[str, float]) -> Values:
    values = {
        "level": c["friction_positive"],
        "breakaway": c["friction_positive"] + c["friction_breakaway"],
    }
    return values if c["friction_shape"] else values | {"velocity": c["friction_speed"]}


def _spring(c: Changes, known: Mapping[str, float]) -> Values:
    return {"stiffness": c["spring"], "preload": c["spring"] * c["spring_rest"]}


_READERS: dict[str, Callable[[Changes, Mapping[str, float]], Values]] = {
    "coulomb_friction": _same(level="friction_positive"),
    "stribeck_friction": _stribeck,
    "presliding_friction": lambda c, known: {
        "level": c["bristle_level"],
        "deflection": c["bristle_level"] / c["bristle_stiffness"],
    },
    "asymmetric_friction": _same(
        level_positive="friction_positive", level_negative="friction_negative"
    ),
    "position_dependent_friction": lambda c, known: {
        "level": c["friction_positive"],
        "wavenumber": c["friction_wave_number"],
        **_wave(c["friction_wave"], c["friction_wave_phase"]),
    },
    "quadratic_drag": _same(coefficient="drag"),
    "backlash": _same(gap="gap", load_inertia="load_inertia"),
    "torsional_compliance": _same(stiffness="shaft_stiffness", load_inertia="load_inertia"),
    "hysteresis": _same(level="slip_force"),
    "cogging_torque": lambda c, known: {
        "wavenumber_1": c["wave_number_1"],
        **_wave(c["wave_1"], c["wave_phase_1"], 1),
    },
    "torque_ripple": _same(wavenumber_1="ripple_number"),
    "gravity_torque": lambda c, known: _wave(-c["pendulum"], c["pendulum_phase"]),
    "elastic_return": _spring,
    "constant_torque_offset": lambda c, known: {"level": c["push"]},
    "actuator_saturation": _same(limit="drive_limit"),
    "actuator_dead_zone": _same(width="dead_width"),
    "actuator_rate_limit": _same(rate="drive_rate"),
    "actuator_lag": _same(time="drive_lag"),
    "actuator_gain_loss": lambda c, known: {"loss": -c["drive_gain_error"]},
    "transport_delay": _same(delay="delay"),
    "thermal_derating": _same(time="heat_time"),
    "supply_voltage_limit": _same(limit="supply_limit", slope="supply_slope"),
    # tanh(u / a) a and u / (1 + (c u)^2) agree to the third order where c^2 = 1 / (3 a^2)
    "magnetic_saturation": lambda c, known: {"coefficient": 1.0 / (np.sqrt(3.0) * c["iron_level"])},
    "sensor_eccentricity": lambda c, known: _wave(c["sensor_eccentricity"], -c["sensor_phase"]),
    "sensor_lag": _same(time="sensor_time"),
    "sensor_offset": lambda c, known: {"level": c["sensor_zero"]},
    "sensor_scale": lambda c, known: {"share": c["sensor_scale"]},
    "periodic_disturbance": lambda c, known: {
        "frequency": c["hum_frequency"],
        **_wave(c["hum"], c["hum_phase"]),
    },
    "pulse_disturbance": lambda c, known: {
        "level": c["pulse"],
        "start": c["pulse_start"],
        "duration": c["pulse_duration"],
    },
    "load_inertia": _same(inertia="load_inertia_extra"),
    "viscous_friction": lambda c, known: {"coefficient": c["viscous"] - known["viscous"]},
}
