"""Heating by a command that is all peaks."""

from __future__ import annotations

from contextlib import closing

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.diagnosis.short_recordings import SERVO, decided, open_small

LOSS, TIME_S, SCALE = 0.01, 0.15, 0.25  # warm [1], [s], effective torque [N.m]


def one_step(t: NDArray[np.float64]) -> NDArray[np.float64]:
    return 0.1 * (t > 0.3).astype(np.float64)


def there_and_back(t: NDArray[np.float64]) -> NDArray[np.float64]:
    return 0.1 * ((t > 0.5) & (t <= 0.9)).astype(np.float64)


@pytest.mark.parametrize("is_there", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_heating_is_found_where_the_peaks_are_16_times_the_effective_command(
    is_there: bool,
) -> None:
    heat = {"loss": LOSS, "time": TIME_S, "scale": SCALE}
    physics = {f"thermal_derating.{name}": value for name, value in heat.items()}
    recordings = SERVO.recordings(
        physics if is_there else {}, (one_step, there_and_back), seconds=3.0
    )
    peak = max(float(np.abs(r.signals["torque_command"]).max()) for r in recordings)
    assert 15.0 * SCALE < peak < 17.0 * SCALE
    with closing((case := open_small(SERVO.twin(), recordings)).simulations):
        decision = decided(case, ("thermal_derating", "actuator_saturation", "magnetic_saturation"))
        scale = case.setting.excitation.effective_current
    if not is_there:  # the negative control
        assert decision.rounds == ()
        return
    (named,) = decision.rounds
    found = named.winner.effect.values
    assert named.winner.name == "thermal_derating"
    assert found["time"] == pytest.approx(TIME_S, rel=0.1)
    # The loss is told at the effective command of the recordings.
    assert scale is not None
    assert found["loss"] / scale**2 == pytest.approx(LOSS / SCALE**2, rel=0.15)
