"""Torque ripple: a share of the motor's torque that repeats over the position."""

from collections.abc import Sequence

import numpy as np

from gmfbo.physics import harmonic
from gmfbo.physics.effect import Effect, Units, Values, signed
from gmfbo.physics.excitation import Excitation
from gmfbo.physics.states import Mask, States
from gmfbo.units import quantity


def _starts(excitation: Excitation) -> Sequence[Values]:
    size = 0.05 * excitation.torque / excitation.current
    growing = [
        {"wavenumber_1": line, "sine_1": size, "cosine_1": size}
        for line in excitation.ripple_wavenumbers
        if harmonic.repeats(line, excitation)
    ]
    return growing + harmonic.starts(excitation, size)


def _acts(states: States, parameters: Values) -> Mask:
    current = np.abs(states.current)
    return np.asarray(current > 0.3 * np.max(current), dtype=np.bool_)


def _statement(parameters: Values, units: Units, place: str) -> str:
    unit = units.resolve("torque/current")
    size = quantity(harmonic.largest_amplitude(parameters), unit)
    often = harmonic.cycles(parameters["wavenumber_1"], units.position == "rad")
    what = f"{units.torque_word.capitalize()} ripple"
    per = " of the command" if unit == "1" else ""
    return f"{what} of about {size}{per} {place}, {often}, is missing from the twin."


torque_ripple = Effect(
    name="torque_ripple",
    port="torque",
    family="harmonic",
    signal_path="plant",
    parameters=(
        signed("sine_1", "Sine amplitude", "torque/current", lambda e: e.torque / e.current),
        signed("cosine_1", "Cosine amplitude", "torque/current", lambda e: e.torque / e.current),
        harmonic.wavenumber("wavenumber_1"),
    ),
    starts=_starts,
    size=lambda p, e: harmonic.largest_amplitude(p),
    size_name="amplitude",
    size_unit="torque/current",
    floor=lambda e: 1.5e-4 * e.torque / e.current,
    not_excited=harmonic.too_short,
    signal=lambda states, p: states.current * harmonic.lines(states, p),
    acts=_acts,
    region=lambda p, units: (
        "over the position where the current is high, "
        + harmonic.cycles(p["wavenumber_1"], units.position == "rad")
    ),
    region_state="position",
    statement=_statement,
    equation="tau = i * sum_k (A_k * sin(n_k * phi) + B_k * cos(n_k * phi))",
    source="Jahns and Soong, 1996",
    confused_with={
        "cogging_torque": "two loads: ripple grows with the current, cogging does not",
        "sensor_eccentricity": "two loads: an eccentric sensor does not answer to current",
    },
)
