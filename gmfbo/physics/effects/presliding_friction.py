"""Presliding friction: the axis gives elastically before it slides."""

from gmfbo.physics import friction
from gmfbo.physics.effect import Effect, sentence

presliding_friction = Effect(
    name="presliding_friction",
    port="torque",
    family="friction",
    signal_path="plant",
    parameters=(
        friction.level(),
        friction.deflection("Deflection before sliding", friction.contact_deflections),
    ),
    starts=lambda e: friction.starts(e, 3, friction.contact_deflections),
    size=lambda p, e: p["level"],
    size_name="level",
    size_unit="torque",
    floor=friction.floor,
    not_excited=friction.no_reversal,
    signal=lambda states, p: -p["level"] * friction.bristle(states.position, p["deflection"]),
    feature=lambda states: -friction.bristle(states.position, friction.typical_deflection(states)),
    acts=friction.acts_at_reversals,
    region=lambda p, units: "where the velocity changes sign, before the axis slides",
    region_state="velocity",
    statement=sentence(
        "Presliding friction of about {level} {place} is missing from the twin: the axis gives "
        "about {deflection} before it slides.",
        level="torque",
        deflection="position",
    ),
    equation="tau = -F_c * z, dz/dphi = (1 - z * sign(omega)) / deflection",
    source="Dahl, 1968",
    contains=("coulomb_friction",),
    as_limit={"level": "level", "deflection": "deflection"},
    confused_with={
        "coulomb_friction": "micro-steps below breakaway, which plain sliding does not answer",
        "hysteresis": "the way back: a bristle turns steeper, a cable or gear bends as at first",
        "torsional_compliance": "a chirp: compliance resonates, a bristle does not",
        "backlash": "micro-steps: a gap gives no torque back, a bristle does",
    },
)
