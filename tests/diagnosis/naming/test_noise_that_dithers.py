"""Small friction and small dead zones under noise that shakes the axis loose of them."""

from __future__ import annotations

import numpy as np
import pytest

from gmfbo import diagnose
from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.misfit import Misfit
from gmfbo.diagnosis.naming import candidate_fits
from gmfbo.diagnosis.naming.candidate_fits import confirm
from gmfbo.diagnosis.screening.testable_effects import candidates
from gmfbo.physics import CATALOGUE
from tests.diagnosis.noise.planted_noise import opened, planted

pytestmark = pytest.mark.slow


def size_of(case: Case, effect: str, parameter: str) -> float:
    """Size at which one effect alone fits recordings."""
    start = candidates([effect], case.setting.excitation)[0]
    (found,) = confirm(case.misfit, case.base, [start])
    return float(found.hypothesis.effects[0].values[parameter])


def unplayed(misfit: Misfit, model: Fitted) -> None:
    return None


CASES = [
    ("actuator_dead_zone", "width", 0.2, 3e-4, 0.01, 0.25),
    pytest.param("actuator_dead_zone", "width", 0.1, 3e-4, 0.02, 0.25, marks=pytest.mark.slow),
    # The quiet fit gains 24 in chi2: too little for any other law to be asked under noise.
    ("actuator_dead_zone", "width", 0.02, 6e-4, 0.15, 0.7),
    ("coulomb_friction", "level", 0.02, 1e-3, 0.05, 0.08),
]


@pytest.mark.parametrize(("effect", "parameter", "true", "sigma", "within", "off"), CASES)
def test_with_the_noise_played_the_size_is_right_and_without_it_smaller(
    effect: str,
    parameter: str,
    true: float,
    sigma: float,
    within: float,
    off: float,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Negative control: the noise bridges part of what is there."""
    with opened(planted(sigma, {f"{effect}.{parameter}": true})) as case:
        assert size_of(case, effect, parameter) == pytest.approx(true, rel=within)
        monkeypatch.setattr(candidate_fits, "under_noise", unplayed)
        found = size_of(case, effect, parameter)
    assert np.isfinite(found)
    assert found < (1.0 - off) * true


def test_a_supply_limit_that_noise_alone_reaches_is_found_with_the_noise_played(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Negative control: without it, the command hardly reaches the limit."""
    with opened(planted(3e-4, {"supply_voltage_limit.limit": 1.5})) as case:
        start = candidates(["supply_voltage_limit"], case.setting.excitation)[0]
        (played,) = confirm(case.misfit, case.base, [start])
        monkeypatch.setattr(candidate_fits, "under_noise", unplayed)
        (quiet,) = confirm(case.misfit, case.base, [start])
        assert 15.0 < case.base.chi2 - played.chi2 < 40.0
        assert -1.0 < case.base.chi2 - quiet.chi2 < 3.0
    limit = played.hypothesis.effects[0].values["limit"]
    assert limit == pytest.approx(1.5, rel=0.03)


@pytest.mark.slow
def test_recordings_that_noise_shakes_do_not_contradict_what_they_show() -> None:
    """A twin without the noise is off by the dead zone that the recorded axis hardly has."""
    found = planted(6e-4, {"actuator_dead_zone.width": 0.12})
    kept = ("actuator_dead_zone", "coulomb_friction", "actuator_gain_loss")
    excluded = [name for name in CATALOGUE if name not in kept]
    diagnosis = diagnose(found.twin, found.recordings, exclude=excluded, jobs=1)
    assert diagnosis.fit.is_worse  # by the quiet twin
    assert [effect.name for effect in diagnosis.effects] == ["actuator_dead_zone"]
    (width,) = diagnosis.effects[0].parameters.values()
    assert width.value == pytest.approx(0.12, rel=0.05)
