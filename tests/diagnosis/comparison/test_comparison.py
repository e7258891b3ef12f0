"""The comparison on the servo axis under noise of the logger: a null and a wrong parameter."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

from gmfbo import FmuTwin, Recording, models_folder
from gmfbo.diagnosis.case.open_case import open_case
from gmfbo.diagnosis.comparison.opened_comparison import comparison_of
from gmfbo.diagnosis.screening.testable_effects import untestable
from gmfbo.physics import CATALOGUE
from gmfbo.sources.twin.augmented_twin import AugmentedTwin

pytestmark = pytest.mark.slow
LOGGER_NOISE = 3e-5  # [rad] of a sensor that the controller does not read


def recordings(hidden: Mapping[str, float], parameters: Mapping[str, float]) -> list[Recording]:
    time = np.linspace(0.0, 2.499, 2500)
    rng = np.random.default_rng(0)
    made = []
    with AugmentedTwin(FmuTwin(models_folder() / "servo_axis.toml"), substeps=10) as axis:
        for hertz in (0.5, 0.9, 1.4, 2.3):
            wave = {"reference": 0.4 * np.sin(2.0 * np.pi * hertz * time)}
            plan = axis.plan(Recording(time=time, signals=wave), {})
            run = axis.run(plan, dict(parameters), dict(hidden))
            noise = LOGGER_NOISE * rng.standard_normal(time.size)
            logged = {**wave, **run.held, "position": run.states["position"] + noise}
            made.append(Recording(time=time, signals=logged))
    return made


@pytest.mark.parametrize(
    ("hidden", "parameters", "found"),
    [
        ({}, {"inertia": 0.0105}, set()),
        ({}, {"inertia": 0.0105, "filter_time": 1.6e-3}, {"parameter:filter_time"}),
    ],
    ids=["nothing hidden", "a wrong fixed parameter"],
)
def test_what_is_hidden_is_believed(
    hidden: Mapping[str, float], parameters: Mapping[str, float], found: set[str]
) -> None:
    twin = FmuTwin(models_folder() / "servo_axis.toml")
    case = open_case(twin, recordings(hidden, parameters), seed=0, jobs=1)
    try:
        reasons = untestable(twin.file, case.setting.excitation, has_inertia=True, is_open=False)
        testable = [name for name in CATALOGUE if name not in reasons]
        ledger, scored = comparison_of(case, testable).run()
    finally:
        case.simulations.close()
    assert scored.best == frozenset(found)
    assert scored.beliefs[scored.elements.index(scored.best)] > 0.9
    best = ledger.rows[scored.best]
    assert best.parameters["inertia"] == pytest.approx(0.0105, rel=2e-3)
    if "parameter:filter_time" in found:
        assert best.parameters["filter_time"] == pytest.approx(1.6e-3, rel=0.05)
