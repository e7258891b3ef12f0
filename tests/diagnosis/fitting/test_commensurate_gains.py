"""An effect gains what the square of its change allows: more is what the model before missed."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.diagnosis.naming.evidence_of_fit import evidence_of
from gmfbo.physics import CATALOGUE
from tests.diagnosis.naming.linear_evidences import WINDOWS, direction, fitted_of
from tests.physics.excitations import TYPICAL

NOISE = np.sqrt(600.0) * direction(1)
MISSED = 20.0
"""Length of what the model without the effect leaves, along what the effect changes."""

EFFECT = Candidate("coulomb_friction", dict(CATALOGUE["coulomb_friction"].starts(TYPICAL)[0]))
NO_CASE = SimpleNamespace(misfit=None)
"""No fit here is so rough that the case would have to simulate."""


def gain_of(change: float) -> float:
    """Gain of an effect that takes so much of what was missed away."""
    along = direction(2)
    before = fitted_of(NOISE + MISSED * along)
    after = fitted_of(NOISE + (MISSED - change) * along, (EFFECT,))
    return evidence_of(NO_CASE, before, after, range(WINDOWS)).gain  # type: ignore[arg-type]


def test_an_effect_at_its_best_keeps_its_gain() -> None:
    square = MISSED**2
    assert gain_of(MISSED) == pytest.approx(square, rel=0.2)


@pytest.mark.parametrize("change", [0.5, 1.0, 3.0])
def test_an_effect_that_changes_next_to_nothing_gains_next_to_nothing(change: float) -> None:
    """Moving a parameter of the twin, which the fit before had left short, falls as far."""
    fall = MISSED**2 - (MISSED - change) ** 2
    assert fall > 5.0 * change**2
    assert gain_of(change) <= 1.25 * change**2 * (1.0 + 1e-9)
