"""A diagnosis says that it goes on, each stage in its turn."""

from __future__ import annotations

from itertools import pairwise

from gmfbo import diagnose
from gmfbo.physics import CATALOGUE
from tests.diagnosis.short_recordings import SERVO

LAWS = ("coulomb_friction", "stribeck_friction", "transport_delay", "gravity_torque")


def test_the_share_done_grows_from_call_to_call_and_within_the_longest_stage() -> None:
    told: list[tuple[str, float]] = []
    recordings = SERVO.recordings({"coulomb_friction.level": 0.2})
    with SERVO.twin() as twin:
        others = sorted(CATALOGUE.keys() - LAWS)
        diagnose(twin, recordings, exclude=others, jobs=2, progress=lambda *one: told.append(one))
    assert all(before[1] <= after[1] for before, after in pairwise(told))
    comparing = [share for stage, share in told if stage == "comparing explanations"]
    assert len(comparing) > 3
    assert len(set(comparing)) == len(comparing)
    order = [stage for stage, _ in told]
    assert order == sorted(order, key=order.index)
    assert told[-1] == ("done", 1.0)
