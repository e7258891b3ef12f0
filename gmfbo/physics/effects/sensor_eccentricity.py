"""Eccentricity of an encoder disc: an error with one cycle a turn."""

import math

import numpy as np

from gmfbo.physics import harmonic, sensor
from gmfbo.physics.effect import Effect, Units, Values, signed
from gmfbo.physics.excitation import Excitation
from gmfbo.physics.states import Array, States
from gmfbo.units import quantity


def _line(excitation: Excitation) -> float:
    """One cycle a turn; along a length, the strongest line or one cycle over the stroke."""
    if excitation.angular:
        return 1.0
    return (*excitation.wavenumbers, 2.0 * math.pi / excitation.stroke)[0]


def _signal(states: States, parameters: Values) -> Array:
    line = parameters.get("wavenumber", 1.0)
    error = harmonic.wave(states, line, parameters["sine"], parameters["cosine"])
    return np.asarray(error - error[0], dtype=np.float64)


def _size(excitation: Excitation) -> float:
    return max(0.01 * excitation.stroke, 3.0 * sensor.floor(excitation))


def _not_excited(excitation: Excitation) -> str | None:
    if excitation.angular and excitation.stroke < 0.35:
        return "the axis turns less than 20 degrees"
    return None


def _statement(parameters: Values, units: Units, place: str) -> str:
    size = quantity(harmonic.amplitude(parameters), units.position)
    return f"A periodic error of the position sensor of about {size} is missing from the twin."


sensor_eccentricity = Effect(
    name="sensor_eccentricity",
    port="sensor",
    family="sensor",
    signal_path="sensor",
    parameters=(
        signed("sine", "Sine amplitude", "position", _size, most=10.0, typical=0.5),
        signed("cosine", "Cosine amplitude", "position", _size, most=10.0, typical=0.5),
    ),
    fixed=lambda e: {"wavenumber": _line(e)},
    starts=lambda e: [{"sine": _size(e), "cosine": _size(e)}],
    size=lambda p, e: harmonic.amplitude(p),
    size_name="amplitude",
    size_unit="position",
    floor=sensor.floor,
    not_excited=_not_excited,
    signal=_signal,
    acts_at_rest=True,
    acts=lambda states, p: states.everywhere(),
    region=lambda p, units: (
        "over the position, one cycle a turn"
        if units.position == "rad"
        else "over the position, in cycles of one length"
    ),
    region_state="position",
    statement=_statement,
    equation="reading = phi + e(phi) - e(phi_start), e = A * sin(n * phi) + B * cos(n * phi)",
    source="Hanselman, 1990",
    contains=("sensor_offset",),
    confused_with={
        "gravity_torque": "standstill at several angles: gravity asks for a holding torque",
        "cogging_torque": "two speeds: an eccentric sensor gives torque as speed squared",
        "sensor_scale": "a whole turn: eccentricity comes back, a scale error does not",
    },
)
