"""A law that holds a simpler one is that one at the values which it names."""

from __future__ import annotations

import numpy as np
import pytest

from gmfbo.physics import CATALOGUE, Effect
from tests.physics.excitations import TYPICAL, swing

LARGER = [law for law in CATALOGUE.values() if law.as_limit]


@pytest.mark.parametrize("effect", LARGER, ids=lambda effect: effect.name)
def test_a_law_at_its_limit_adds_what_the_simpler_one_adds(effect: Effect) -> None:
    (name,) = effect.contains
    simpler = CATALOGUE[name]
    assert set(effect.as_limit) <= {p.name for p in effect.parameters}
    assert set(effect.as_limit.values()) <= {
        p.name for p in (*simpler.parameters, *simpler.own_nuisances)
    }
    values = {"level": 0.3, "deflection": 1e-6}
    start = effect.starts(TYPICAL)[0]
    own = {
        p.name: values[effect.as_limit[p.name]]
        if p.name in effect.as_limit
        else start[p.name] * (0.0 if p.low(TYPICAL) <= 0.0 else 1.0)
        for p in effect.parameters
    }
    states = swing()
    assert effect.signal is not None
    assert simpler.signal is not None
    moving = np.abs(states.velocity) > 0.2 * np.abs(states.velocity).max()
    moving[:20] = False  # a bristle begins without any deflection
    made, expected = effect.signal(states, own), simpler.signal(states, values)
    np.testing.assert_allclose(made[moving], expected[moving], rtol=1e-3)
    # Elsewhere it is another law.
    more = {n: v if n in effect.as_limit else start[n] for n, v in own.items()}
    if more != own:
        assert not np.allclose(effect.signal(states, more)[moving], expected[moving], rtol=1e-2)
