"""The floor of the table is the error of a right twin, whoever reads the noise."""

from __future__ import annotations

import pytest

from gmfbo import diagnose
from tests.diagnosis.noise.planted_noise import planted

SIGMA = 2e-4  # [rad]


@pytest.mark.parametrize("is_felt", [True, False], ids=["round the loop", "in the log alone"])
def test_a_right_twin_is_at_the_floor(is_felt: bool) -> None:
    """Noise of the log alone had been sent round the loop: ten times the command's own here."""
    found = planted(SIGMA, is_felt=is_felt)
    seen = diagnose(found.twin, found.recordings, assume=[], jobs=1)
    assert seen.verdict in ("parameters", "none")
    for fit in seen.fit.signals.values():
        assert fit.parameters_only == pytest.approx(fit.noise_floor, rel=0.15)
