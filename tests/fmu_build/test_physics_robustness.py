"""physics.fmu far outside of what makes sense: finite numbers, or words."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

if TYPE_CHECKING:
    from tests.fmu_build.conftest import NewInstance

OUTPUTS = ("torque", "command", "sensor", "tracking.effort")


def test_any_parameters_and_inputs_give_finite_outputs(new_instance: NewInstance) -> None:
    """Sizes from 1e-12 to 1e6 and zeros wherever a bound allows them, inputs that jump."""
    rng = np.random.default_rng(0)
    effects = new_instance("physics")
    variables = effects.variables.values()
    inputs = [variable.name for variable in variables if variable.causality == "input"]
    tunable = [variable for variable in variables if variable.causality == "parameter"]

    def size() -> float:
        return float(rng.choice([-1.0, 0.0, 1.0]) * 10.0 ** rng.uniform(-12.0, 6.0))

    for _ in range(60):
        effects.slave.reset()
        for variable in tunable:
            low, high = float(variable.min or -np.inf), float(variable.max or np.inf)
            effects.set(**{variable.name: min(max(size(), low), high)})
        effects.start()
        step = 10.0 ** rng.uniform(-4.0, -2.3)
        for k in range(20):
            effects.set(**{name: float(rng.normal(0.0, 10.0)) for name in inputs})
            effects.step(k * step, step)
            assert np.all(np.isfinite([effects.get(name) for name in OUTPUTS]))


def test_a_diverged_torque_is_reported_in_words(new_instance: NewInstance) -> None:
    effects = new_instance("physics").start(quadratic_drag__coefficient=1e300)
    effects.set(state__velocity=1e300)
    with pytest.raises(RuntimeError, match="an effect has diverged: its size, or the state"):
        effects.step(0.0, 1e-3)
