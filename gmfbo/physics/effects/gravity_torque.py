"""Gravity or unbalance: a torque with one cycle a turn."""

from gmfbo.physics import harmonic
from gmfbo.physics.effect import Effect, Units, Values, signed
from gmfbo.physics.excitation import Excitation
from gmfbo.units import quantity


def _not_excited(excitation: Excitation) -> str | None:
    if not excitation.angular:
        return "the position is a length: gravity is a constant force along it"
    if excitation.stroke < 0.35:
        return "the axis turns less than 20 degrees"
    return None


def _statement(parameters: Values, units: Units, place: str) -> str:
    size = quantity(harmonic.amplitude(parameters), units.torque)
    return (
        f"A {units.torque_word} of gravity or unbalance of about {size} {place} "
        "is missing from the twin."
    )


gravity_torque = Effect(
    name="gravity_torque",
    port="torque",
    family="harmonic",
    signal_path="plant",
    parameters=(
        signed("sine", "Sine amplitude", "torque", lambda e: e.torque),
        signed("cosine", "Cosine amplitude", "torque", lambda e: e.torque),
    ),
    starts=lambda e: [{"sine": 0.05 * e.torque, "cosine": 0.05 * e.torque}],
    size=lambda p, e: harmonic.amplitude(p),
    size_name="amplitude",
    size_unit="torque",
    floor=lambda e: 1.5e-4 * e.torque,
    not_excited=_not_excited,
    signal=lambda states, p: harmonic.wave(states, 1.0, p["sine"], p["cosine"]),
    acts_at_rest=True,
    acts=lambda states, p: states.everywhere(),
    region=lambda p, units: "over the position, one cycle a turn",
    region_state="position",
    statement=_statement,
    equation="tau = A * sin(phi) + B * cos(phi)",
    source="Newton, 1687",
    contains=("constant_torque_offset",),
    confused_with={
        "elastic_return": "a large-angle sweep: gravity turns back, a spring goes on",
        "constant_torque_offset": "a large-angle sweep: an offset stays",
        "sensor_eccentricity": "standstill at several angles: gravity asks for a holding torque",
        "cogging_torque": "a full turn: gravity has one cycle, cogging many",
    },
)
