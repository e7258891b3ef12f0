"""A name that a free function could replace stays where it explains most; a small one goes."""

from __future__ import annotations

from typing import cast

import pytest

from gmfbo.diagnosis.comparison.claims import Claim
from gmfbo.diagnosis.comparison.unknown.beside import Unknown
from gmfbo.diagnosis.comparison.unknown.curve import FreeFunction
from gmfbo.diagnosis.naming.decided_by_score import _beside
from tests.diagnosis.short_recordings import SERVO, decided, open_small

PHYSICS = {
    "coulomb_friction.level": 0.25,
    "coulomb_friction.deflection": 1e-6,
    "transport_delay.delay": 1.2e-3,
}


def over_the_velocity(*beside: str) -> Unknown:
    """A function that has everything but these names in it; nothing here looks at it."""
    function = cast("FreeFunction", None)
    return Unknown("torque", "velocity", 1.0, 40.0, frozenset(beside), function)


@pytest.mark.slow
def test_what_explains_most_is_named_and_what_explains_little_is_not() -> None:
    """Friction, and a delay that explains little beside it."""
    case = open_small(SERVO.twin(), SERVO.recordings(PHYSICS))
    try:
        found = decided(case, ("coulomb_friction", "transport_delay"))
        friction, delay = (Claim((one.winner.name,), (one.belief,)) for one in found.rounds)
        claims = [friction, delay]
        assert [claim.members[0] for claim in claims] == ["coulomb_friction", "transport_delay"]
        assert _beside(found.compared, claims, None, {}) == (claims, [])
        kept, (note,) = _beside(found.compared, claims, over_the_velocity(), {})
        assert kept == [friction]
        assert note.startswith("transport delay is not named: a function of the velocity")
        both = over_the_velocity("transport_delay")
        assert _beside(found.compared, claims, both, {}) == (claims, [])
    finally:
        case.simulations.close()
