"""Cogging: a torque that repeats over the position, with or without current."""

from collections.abc import Sequence

from gmfbo.physics import harmonic
from gmfbo.physics.effect import Effect, Values, signed
from gmfbo.physics.excitation import Excitation
from gmfbo.physics.units import Units, quantity


def _starts(excitation: Excitation) -> Sequence[Values]:
    size = 0.05 * excitation.torque
    return [
        {"wavenumber_1": line, "sine_1": size, "cosine_1": size}
        for line in harmonic.wavenumbers(excitation)
    ]


def _statement(parameters: Values, units: Units, place: str) -> str:
    size = quantity(harmonic.largest_amplitude(parameters), units.torque)
    often = harmonic.cycles(parameters["wavenumber_1"], units.position == "rad")
    return f"Cogging of about {size} {place}, {often}, is missing from the twin."


cogging_torque = Effect(
    name="cogging_torque",
    port="torque",
    family="harmonic",
    signal_path="plant",
    parameters=(
        signed("sine_1", "Sine amplitude", "torque", lambda e: e.torque),
        signed("cosine_1", "Cosine amplitude", "torque", lambda e: e.torque),
        harmonic.wavenumber("wavenumber_1"),
    ),
    starts=_starts,
    size=lambda p, e: harmonic.largest_amplitude(p),
    size_name="amplitude",
    size_unit="torque",
    floor=lambda e: 1.5e-4 * e.torque,
    not_excited=harmonic.too_short,
    signal=harmonic.lines,
    acts=lambda states, p: states.everywhere(),
    region=lambda p, units: (
        f"over the position, {harmonic.cycles(p['wavenumber_1'], units.position == 'rad')}"
    ),
    region_state="position",
    statement=_statement,
    equation="tau = sum_k A_k * sin(n_k * phi) + B_k * cos(n_k * phi)",
    source="Jahns and Soong, 1996",
    confused_with={
        "torque_ripple": "two loads: ripple grows with the current, cogging does not",
        "gravity_torque": "a full turn: gravity has one cycle, cogging many",
        "periodic_disturbance": "two speeds: cogging stays fixed to the position",
        "sensor_eccentricity": "two speeds: an eccentric sensor gives torque as speed squared",
    },
)
