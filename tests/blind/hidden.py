"""The hidden effects: each as changes of the true plant, with what a right answer says of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from tests.blind.machines import Machine

Rng = np.random.Generator
Changes = dict[str, float]


@dataclass(frozen=True)
class Setting:
    """What an effect is put into.

    Attributes
    ----------
    machine : Machine
        Kind of axis.
    values : mapping of str to float
        True parameters without the effect.
    peak_command, rms_command, peak_slew : float
        [command], [command], [command/s] Of the recordings without the effect.
    peak_speed, travel : float
        [position/s], [position] Largest speed and distance from zero.
    peak_mix : float
        Largest |sum| of command and velocity, each as a share of its own peak.
    """

    machine: Machine
    values: Mapping[str, float]
    peak_command: float
    rms_command: float
    peak_slew: float
    peak_speed: float
    travel: float
    peak_mix: float

    @property
    def torque(self) -> float:
        """[torque] That of the largest command."""
        return self.peak_command * self.values["torque_gain"]


Maker = Callable[[Setting, Rng], Callable[[float], Changes]]
"""Draws the shape of an effect once; then gives the plant's changes for any size."""


@dataclass(frozen=True)
class Hidden:
    """One kind of hidden effect.

    Attributes
    ----------
    make : callable
        Draws its shape, and turns a size into changes of the true plant.
    port : str
        Port that the diagnosis needs for it.
    paths : tuple of str
        Signal paths that count as right.
    states : tuple of str
        States that a right answer may name: velocity, position, command, time; empty for none.
    low, high : callable
        Smallest and largest size that is plausible there.
    windows : str
        Where it shows: at `reversals`, while `active`, or "" for always.
    rotary_only : bool
        It makes no sense elsewhere.
    measured_only : bool
        Where inertia and viscous friction are uncertain, it is one of these.
    """

    make: Maker
    port: str
    paths: tuple[str, ...]
    states: tuple[str, ...]
    low: Callable[[Setting], float]
    high: Callable[[Setting], float]
    windows: str = ""
    rotary_only: bool = False
    measured_only: bool = False


def _coulomb(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    return lambda size: {"friction_positive": size, "friction_negative": size}


def _stribeck(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    speed, rise = s.machine.speed * rng.uniform(0.5, 2.0), rng.uniform(0.5, 1.2)
    shape = float(rng.random() < 0.3)  # Lorentz instead of Gauss
    return lambda size: {
        "friction_positive": size,
        "friction_negative": size,
        "friction_breakaway": rise * size,
        "friction_speed": speed,
        "friction_shape": shape,
    }


def _presliding(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    deflection, damping = s.machine.deflection * rng.uniform(0.5, 2.5), rng.uniform(0.1, 0.5)
    return lambda size: {
        "bristle_level": size,
        "bristle_stiffness": size / deflection,
        "bristle_damping": damping * size / s.peak_speed,
    }


def _asymmetric(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    share = rng.uniform(0.3, 0.6) * rng.choice([-1.0, 1.0])
    return lambda size: {
        "friction_positive": size * (1.0 + share),
        "friction_negative": size * (1.0 - share),
    }


def _load_dependent(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    base = rng.uniform(0.0, 0.03) * s.torque
    return lambda size: {
        "friction_torque_share": size,
        "friction_positive": base * min(1.0, size / 0.1),
        "friction_negative": base * min(1.0, size / 0.1),
    }


def _position_dependent(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    # About half a turn to two turns of its wave over the travel of the recordings.
    number = rng.uniform(0.5, 2.0) * np.pi / s.travel
    share, phase = rng.uniform(0.5, 0.9), rng.uniform(0.0, 2.0 * np.pi)
    return lambda size: {
        "friction_positive": size,
        "friction_negative": size,
        "friction_wave": share * size,
        "friction_wave_number": float(number),
        "friction_wave_phase": phase,
    }


def _drag(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    return lambda size: {"drag": size}


def _two_masses(s: Setting, rng: Rng) -> Changes:
    share = rng.uniform(0.3, 0.55)
    inertia = s.values["inertia"]
    return {"load_inertia": share * inertia, "inertia": (1.0 - share) * inertia}


def _backlash(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    masses = _two_masses(s, rng)
    exponent = rng.uniform(1.1, 1.5)
    # Under a third of the torque the load rings on its contact at 600 Hz: as good as rigid.
    force = 0.3 * s.torque
    depth = force / (masses["load_inertia"] * (2.0 * np.pi * 600.0) ** 2)
    stiffness = force / depth**exponent
    damping = rng.uniform(0.2, 0.6) / s.machine.speed
    return lambda size: {
        **masses,
        "gap": size,
        "shaft_stiffness": float(stiffness),
        "contact_exponent": exponent,
        "contact_damping": damping,
    }


def _compliance(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    masses = _two_masses(s, rng)
    ratio = rng.uniform(0.03, 0.08)

    def changes(size: float) -> Changes:  # [position/torque]
        stiffness = 1.0 / size
        damping = 2.0 * ratio * np.sqrt(stiffness * masses["load_inertia"])
        return {**masses, "shaft_stiffness": stiffness, "shaft_damping": float(damping)}

    return changes


def _hysteresis(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    length = s.machine.deflection * rng.uniform(5.0, 20.0)
    return lambda size: {"slip_force": size, "slip_length": length}


def _cogging(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    number, shares = _wave_number(s, rng), rng.uniform(0.15, 0.5, 2)
    phases = rng.uniform(0.0, 2.0 * np.pi, 3)
    return lambda size: {
        "wave_1": size,
        "wave_number_1": number,
        "wave_phase_1": float(phases[0]),
        "wave_2": float(size * shares[0]),
        "wave_number_2": 2.0 * number,
        "wave_phase_2": float(phases[1]),
        "wave_3": float(size * shares[0] * shares[1]),
        "wave_number_3": 4.0 * number,
        "wave_phase_3": float(phases[2]),
    }


def _wave_number(s: Setting, rng: Rng) -> float:
    low, high = s.machine.lines
    number = float(np.exp(rng.uniform(np.log(low), np.log(high))))
    return float(round(number)) if s.machine.is_rotary else number


def _ripple(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    number, phase = _wave_number(s, rng), rng.uniform(0.0, 2.0 * np.pi)
    return lambda size: {"ripple": size, "ripple_number": number, "ripple_phase": phase}


def _gravity(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    phase = rng.uniform(0.0, 2.0 * np.pi)
    return lambda size: {"pendulum": size, "pendulum_phase": phase}


def _spring(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    rest = rng.uniform(-0.5, 0.5) * s.travel
    return lambda size: {"spring": size, "spring_rest": rest}


def _push(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    way = rng.choice([-1.0, 1.0])
    return lambda size: {"push": float(way * size)}


def _saturation(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    return lambda size: {"drive_limit": s.peak_command * (1.0 - size)}


def _supply(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    # At size zero the limit only touches the recordings' worst point.
    return lambda size: {
        "supply_limit": s.peak_mix * s.peak_command * (1.0 - size),
        "supply_slope": s.peak_command / s.peak_speed,
    }


def _dead_zone(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    return lambda size: {"dead_width": size}


def _rate(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    # A command that is held jumps: any rate turns its steps into ramps, slow ones stay behind.
    return lambda size: {"drive_rate": s.peak_slew / size}


def _lag(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    return lambda size: {"drive_lag": size}


def _delay(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    return lambda size: {"delay": size}


def _heat(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    time, scale = rng.uniform(0.4, 1.2), s.rms_command * rng.uniform(0.8, 1.5)
    return lambda size: {"heat_loss": size, "heat_time": time, "heat_scale": float(scale)}


def _iron(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    return lambda size: {"iron_level": s.peak_command / float(np.sqrt(3.0 * size))}


def _eccentricity(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    phase = rng.uniform(0.0, 2.0 * np.pi)
    return lambda size: {"sensor_eccentricity": size, "sensor_phase": phase}


def _sensor_lag(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    return lambda size: {"sensor_time": size}


def _hum(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    frequency, phase = rng.uniform(3.0, 25.0), rng.uniform(0.0, 2.0 * np.pi)
    return lambda size: {"hum": size, "hum_frequency": frequency, "hum_phase": phase}


def _pulse(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    start, duration = rng.uniform(0.6, 1.6), rng.uniform(0.06, 0.3)
    way = rng.choice([-1.0, 1.0])
    return lambda size: {
        "pulse": float(way * size),
        "pulse_start": start,
        "pulse_duration": duration,
    }


def _viscous(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    return lambda size: {"viscous": s.values["viscous"] + size}


def _gain_loss(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    return lambda size: {"drive_gain_error": -size}


def _sensor_offset(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    way = rng.choice([-1.0, 1.0])
    return lambda size: {"sensor_zero": float(way * size)}


def _sensor_scale(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    way = rng.choice([-1.0, 1.0])
    return lambda size: {"sensor_scale": float(way * size)}


def _load(s: Setting, rng: Rng) -> Callable[[float], Changes]:
    return lambda size: {"load_inertia_extra": size}


def _share_of_torque(share: float) -> Callable[[Setting], float]:
    return lambda s: share * s.torque


def _fixed(value: float) -> Callable[[Setting], float]:
    return lambda s: value


_TORQUES = (_share_of_torque(2e-5), _share_of_torque(0.3))
_PLANT = ("plant",)
_GEAR = ("transmission",)
_DRIVE = ("actuator",)
_SPEED = ("velocity",)
_PLACE = ("position",)
_COMMAND = ("command",)
_TIME = ("time",)

EFFECTS: dict[str, Hidden] = {
    "coulomb_friction": Hidden(_coulomb, "torque", _PLANT, _SPEED, *_TORQUES, "reversals"),
    "stribeck_friction": Hidden(_stribeck, "torque", _PLANT, _SPEED, *_TORQUES, "reversals"),
    "presliding_friction": Hidden(_presliding, "torque", _PLANT, _SPEED, *_TORQUES, "reversals"),
    "asymmetric_friction": Hidden(_asymmetric, "torque", _PLANT, _SPEED, *_TORQUES, "reversals"),
    "load_dependent_friction": Hidden(
        _load_dependent,
        "torque",
        ("plant", "transmission"),
        _SPEED,
        _fixed(1e-4),
        _fixed(0.5),
        "reversals",
    ),
    "position_dependent_friction": Hidden(
        _position_dependent, "torque", _PLANT, ("position", "velocity"), *_TORQUES
    ),
    "quadratic_drag": Hidden(
        _drag,
        "torque",
        _PLANT,
        _SPEED,
        lambda s: 1e-4 * s.torque / s.peak_speed**2,
        lambda s: 0.8 * s.torque / s.peak_speed**2,
    ),
    "backlash": Hidden(
        _backlash,
        "torque",
        _GEAR,
        _SPEED,
        lambda s: 2e-3 * s.machine.deflection,
        lambda s: 5.0 * s.machine.deflection,
        "reversals",
    ),
    "torsional_compliance": Hidden(
        _compliance,
        "torque",
        _GEAR,
        (),
        lambda s: 1.0 / (s.values["inertia"] * 0.4 * (2.0 * np.pi * 250.0) ** 2),
        lambda s: 1.0 / (s.values["inertia"] * 0.4 * (2.0 * np.pi * 18.0) ** 2),
    ),
    "hysteresis": Hidden(
        _hysteresis, "torque", ("transmission", "plant"), ("position", "velocity"), *_TORQUES, ""
    ),
    "cogging_torque": Hidden(_cogging, "torque", _PLANT, _PLACE, *_TORQUES),
    "torque_ripple": Hidden(
        _ripple, "torque", ("actuator", "plant"), _PLACE, _fixed(1e-4), _fixed(0.4)
    ),
    "gravity_torque": Hidden(_gravity, "torque", _PLANT, _PLACE, *_TORQUES, "", rotary_only=True),
    "elastic_return": Hidden(
        _spring,
        "torque",
        _PLANT,
        _PLACE,
        lambda s: 2e-5 * s.torque / s.travel,
        lambda s: 0.3 * s.torque / s.travel,
    ),
    "constant_torque_offset": Hidden(_push, "torque", _PLANT, (), *_TORQUES),
    "actuator_saturation": Hidden(
        _saturation, "command", _DRIVE, _COMMAND, _fixed(1e-3), _fixed(0.75), "active"
    ),
    "actuator_dead_zone": Hidden(
        _dead_zone,
        "command",
        _DRIVE,
        _COMMAND,
        lambda s: 2e-5 * s.peak_command,
        lambda s: 0.15 * s.peak_command,
    ),
    "actuator_rate_limit": Hidden(
        _rate, "command", _DRIVE, _COMMAND, _fixed(0.02), _fixed(8.0), "active"
    ),
    "actuator_lag": Hidden(_lag, "command", _DRIVE, (), _fixed(2e-5), _fixed(5e-3)),
    "transport_delay": Hidden(
        _delay, "command", ("actuator", "controller"), (), _fixed(2e-5), _fixed(4e-3)
    ),
    "thermal_derating": Hidden(_heat, "command", _DRIVE, _TIME, _fixed(1e-5), _fixed(0.4)),
    "supply_voltage_limit": Hidden(
        _supply, "command", _DRIVE, ("velocity", "command"), _fixed(1e-4), _fixed(0.8), "active"
    ),
    "magnetic_saturation": Hidden(_iron, "command", _DRIVE, _COMMAND, _fixed(1e-4), _fixed(0.5)),
    "sensor_eccentricity": Hidden(
        _eccentricity,
        "sensor",
        ("sensor",),
        _PLACE,
        _fixed(1e-6),
        _fixed(0.05),
        rotary_only=True,
    ),
    "sensor_lag": Hidden(_sensor_lag, "sensor", ("sensor",), (), _fixed(2e-5), _fixed(4e-3)),
    "periodic_disturbance": Hidden(_hum, "torque", _PLANT, _TIME, *_TORQUES),
    "pulse_disturbance": Hidden(_pulse, "torque", _PLANT, _TIME, *_TORQUES, "active"),
    "viscous_friction": Hidden(
        _viscous,
        "torque",
        _PLANT,
        _SPEED,
        lambda s: 1e-5 * s.torque / s.peak_speed,
        lambda s: 0.5 * s.torque / s.peak_speed,
        measured_only=True,
    ),
    "load_inertia": Hidden(
        _load,
        "torque",
        _PLANT,
        (),
        lambda s: 1e-5 * s.values["inertia"],
        lambda s: s.values["inertia"],
        measured_only=True,
    ),
    "actuator_gain_loss": Hidden(
        _gain_loss, "command", _DRIVE, (), _fixed(1e-4), _fixed(0.5), measured_only=True
    ),
    "sensor_offset": Hidden(
        _sensor_offset,
        "sensor",
        ("sensor",),
        (),
        lambda s: s.machine.quantum,
        lambda s: 0.2 * s.travel,
    ),
    "sensor_scale": Hidden(
        _sensor_scale, "sensor", ("sensor",), (), _fixed(1e-5), _fixed(0.2), measured_only=True
    ),
}
"""By the name that a right diagnosis gives."""

FRICTION = frozenset(
    {
        "coulomb_friction",
        "stribeck_friction",
        "presliding_friction",
        "asymmetric_friction",
        "load_dependent_friction",
        "position_dependent_friction",
    }
)
"""Laws that count as one family."""
