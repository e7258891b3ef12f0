"""Cogging: a torque that repeats over the position, with or without current, in several lines."""

from collections.abc import Iterator, Sequence

from gmfbo.physics import harmonic
from gmfbo.physics.effect import Effect, EffectParameter, Units, Values, signed
from gmfbo.physics.excitation import Excitation
from gmfbo.units import quantity


def _starts(excitation: Excitation) -> Sequence[Values]:
    """Start from strong lines alone, and from all that were found together."""
    size = 0.05 * excitation.torque
    alone = harmonic.starts(excitation, size)
    found = harmonic.repeating(excitation)
    together = {
        f"{name}_{i}": value
        for i, line in enumerate(found, 1)
        for name, value in (("wavenumber", line), ("sine", size), ("cosine", size))
    }
    return [*alone, together] if len(found) > 1 else alone


def _lines() -> Iterator[EffectParameter]:
    for i in range(1, harmonic.MOST + 1):
        yield signed(f"sine_{i}", "Sine amplitude", "torque", lambda e: e.torque)
        yield signed(f"cosine_{i}", "Cosine amplitude", "torque", lambda e: e.torque)
        yield harmonic.wavenumber(f"wavenumber_{i}")


def _statement(parameters: Values, units: Units, place: str) -> str:
    angular = units.position == "rad"
    if "wavenumber_2" in parameters:
        lines = harmonic.told(parameters, angular, lambda size: quantity(size, units.torque))
        return f"Cogging {place} of about {lines} is missing from the twin."
    size = quantity(harmonic.largest_amplitude(parameters), units.torque)
    often = harmonic.told(parameters, angular)
    return f"Cogging of about {size} {place}, {often}, is missing from the twin."


cogging_torque = Effect(
    name="cogging_torque",
    port="torque",
    family="harmonic",
    signal_path="plant",
    parameters=tuple(_lines()),
    starts=_starts,
    size=lambda p, e: harmonic.largest_amplitude(p),
    size_name="amplitude",
    size_unit="torque",
    floor=lambda e: 1.5e-4 * e.torque,
    not_excited=harmonic.too_short,
    signal=harmonic.lines,
    acts_at_rest=True,
    acts=lambda states, p: states.everywhere(),
    region=lambda p, units: f"over the position, {harmonic.told(p, units.position == 'rad')}",
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
