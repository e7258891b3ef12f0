"""`none` and `parameters` follow from the score: what its intervals tell apart is not nothing."""

from __future__ import annotations

import pytest

from tests.diagnosis.short_recordings import Axis, diagnosed

FEW = ("coulomb_friction", "transport_delay")


@pytest.mark.parametrize(("factor", "verdict"), [(1.0, "none"), (1.003, "parameters")])
def test_a_twin_whose_inertia_is_off_by_little_is_not_right(factor: float, verdict: str) -> None:
    """A norm that forgave half a per cent of each signal had said "nothing" beside an interval
    that leaves the twin's value out.
    """
    axis = Axis(truth={"inertia": 0.01 * factor, "viscous": 0.05})
    found = diagnosed(axis.twin(), axis.recordings({}), only=FEW)
    inertia = found.parameters["inertia"]
    assert inertia.low <= 0.01 * factor <= inertia.high
    assert (inertia.low <= 0.01 <= inertia.high) == (verdict == "none")
    assert found.verdict == verdict
