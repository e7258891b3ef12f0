"""A trace that averages over its rows hides nothing, and shows nothing that is not there."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

from gmfbo.diagnosis.naming.decision import Decision
from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin.augmented_twin import AugmentedTwin
from tests.diagnosis.short_recordings import (
    SERVO,
    SERVO_NOISE,
    decided,
    moves,
    multisine,
    open_small,
)

LAWS = ("coulomb_friction", "load_inertia", "transport_delay", "sensor_lag")
FAST = 4  # samples of the controller in a row of the logger

pytestmark = pytest.mark.slow


def decision_on(physics: Mapping[str, float]) -> Decision:
    """What is decided on rows that are means over the samples of a faster controller."""
    rng = np.random.default_rng(5)
    time = np.arange(1400, dtype=np.float64) * 1e-3
    gains = {**SERVO.gains, "sample_time": 1e-3 / FAST}
    recordings = []
    with SERVO.twin() as twin, AugmentedTwin(twin, substeps=FAST) as axis:
        for k, reference in enumerate((multisine, moves)):
            asked = Recording(
                time=time,
                signals={"reference": reference(time)},
                name=f"rec{k}.csv",
                parameters=gains,
                written_by="test",
            )
            run = axis.run(axis.plan(asked, SERVO.truth), SERVO.truth, physics)
            columns = {
                name: column + SERVO_NOISE[name] * rng.standard_normal(time.size)
                for name, column in run.mean.items()
            }
            recordings.append(asked.with_signals(columns))
    case = open_small(SERVO.twin(), recordings)
    with case.simulations:
        return decided(case, LAWS)


def test_nothing_is_missing_where_only_the_logger_averages() -> None:
    decision = decision_on({})
    assert not decision.rounds
    assert not decision.freed
    assert not decision.is_outside


def test_friction_is_found_behind_a_logger_that_averages() -> None:
    decision = decision_on({"coulomb_friction.level": 0.2})
    assert [found.winner.name for found in decision.rounds] == ["coulomb_friction"]
    level = decision.row.hypothesis.effects[0].values["level"]
    assert level == pytest.approx(0.2, rel=0.02)
