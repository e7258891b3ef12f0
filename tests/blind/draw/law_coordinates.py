"""The free values of each true law: what a fit of the plant moves, and by what small step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tests.blind.draw.equivalents import PARAMETER, same_statement
from tests.blind.true_values import true_values
from tests.blind.truth import Vector

STEP = 1e-3
"""Small change of the logarithm of a value, for differences."""

_COARSE = 1e-2
"""The same where a run is only smooth on the average: contacts, and ends of a pulse."""

_COARSELY = frozenset({"gap", "load_inertia", "shaft_stiffness", "pulse_duration", "pulse_start"})
_FRICTION = ("friction_positive", "friction_negative")

FREE: Mapping[str, tuple[tuple[str, ...], ...]] = {
    "coulomb_friction": (_FRICTION,),
    "stribeck_friction": (_FRICTION, ("friction_breakaway",), ("friction_speed",)),
    "presliding_friction": (("bristle_level",), ("bristle_stiffness",), ("bristle_damping",)),
    "asymmetric_friction": (("friction_positive",), ("friction_negative",)),
    "load_dependent_friction": (("friction_torque_share",), _FRICTION),
    "position_dependent_friction": (
        _FRICTION,
        ("friction_wave",),
        ("friction_wave_number",),
        ("friction_wave_phase",),
    ),
    "quadratic_drag": (("drag",),),
    "backlash": (("gap",), ("load_inertia",)),
    "torsional_compliance": (("shaft_stiffness",), ("shaft_damping",), ("load_inertia",)),
    "hysteresis": (("slip_force",), ("slip_length",)),
    "cogging_torque": (
        ("wave_number_1", "wave_number_2", "wave_number_3"),
        *((f"{own}_{line}",) for line in (1, 2, 3) for own in ("wave", "wave_phase")),
    ),
    "torque_ripple": (("ripple",), ("ripple_number",), ("ripple_phase",)),
    "gravity_torque": (("pendulum",), ("pendulum_phase",)),
    "elastic_return": (("spring",), ("spring_rest",)),
    "constant_torque_offset": (("push",),),
    "actuator_saturation": (("drive_limit",),),
    "actuator_dead_zone": (("dead_width",),),
    "actuator_rate_limit": (("drive_rate",),),
    "actuator_lag": (("drive_lag",),),
    "transport_delay": (("delay",),),
    "thermal_derating": (("heat_loss",), ("heat_time",)),
    "supply_voltage_limit": (("supply_limit",), ("supply_slope",)),
    "magnetic_saturation": (("iron_level",),),
    "sensor_eccentricity": (("sensor_eccentricity",), ("sensor_phase",)),
    "sensor_lag": (("sensor_time",),),
    "periodic_disturbance": (("hum_frequency",), ("hum",), ("hum_phase",)),
    "pulse_disturbance": (("pulse",), ("pulse_start",), ("pulse_duration",)),
    "viscous_friction": (("viscous",),),
    "load_inertia": (("load_inertia_extra",),),
    "actuator_gain_loss": (("drive_gain_error",),),
    "sensor_offset": (("sensor_zero",),),
    "sensor_scale": (("sensor_scale",),),
}
"""Plant parameters by law; those of one entry move in proportion. What is not listed is held at
its true value: the form of a contact, of Stribeck's curve, and the scale of a derating's heat,
which only its loss over the square of it shows."""


@dataclass(frozen=True)
class Coordinates:
    """A true plant about which some values are free, each as the logarithm of its factor.

    Attributes
    ----------
    plant : mapping of str to float
        True values, of all that is hidden too.
    groups : sequence of tuple of str
        Plant parameters that move together, in proportion.
    """

    plant: Mapping[str, float]
    groups: Sequence[tuple[str, ...]]

    def at(self, x: Vector) -> dict[str, float]:
        """Values of the plant at a point, which is zero at the truth."""
        values = dict(self.plant)
        for names, step in zip(self.groups, x, strict=True):
            for name in names:
                values[name] *= float(np.exp(step))
        return values

    @property
    def steps(self) -> Vector:
        """By which each is moved for a difference, shape (n_groups,)."""
        return np.array([_COARSE if _COARSELY & set(own) else STEP for own in self.groups])


def coordinates(
    plant: Mapping[str, float], laws: Sequence[str], parameters: Sequence[str]
) -> Coordinates:
    """All that a fit of the true law moves: values of the laws, parameters of the twin.

    Parameters
    ----------
    plant : mapping of str to float
        True values.
    laws : sequence of str
        That are hidden.
    parameters : sequence of str
        Plant parameters that the twin knows roughly. One that is zero has no logarithm: it is held.
    """
    own = [(name,) for name in parameters] + [group for law in laws for group in FREE[law]]
    kept = [group for group in dict.fromkeys(own) if all(plant.get(name) for name in group)]
    return Coordinates(plant, kept)


def reported(
    name: str, plant: Mapping[str, float], known: Mapping[str, float], fmu_names: Mapping[str, str]
) -> float:
    """A value of the plant by the name under which a diagnosis tells it.

    Parameters
    ----------
    name : str
        `LAW.VALUE`, or the FMU name of a parameter.
    plant : mapping of str to float
        With what is hidden.
    known : mapping of str to float
        The plant without.
    fmu_names : mapping of str to str
        Plant parameter by FMU name.
    """
    if name in fmu_names:
        own = plant[fmu_names[name]]
        is_inertia = same_statement(PARAMETER + name) == "load_inertia"
        return own + (plant.get("load_inertia", 0.0) if is_inertia else 0.0)
    law, value = name.split(".", 1)
    return true_values(law, dict(plant), known)[value]
