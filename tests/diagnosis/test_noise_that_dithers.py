"""Small friction and small dead zones under noise that shakes the axis loose of them."""

from __future__ import annotations

import numpy as np
import pytest

from gmfbo import diagnose
from gmfbo.diagnosis import confirming
from gmfbo.diagnosis.confirming import confirm
from gmfbo.diagnosis.fitting import Fitted
from gmfbo.diagnosis.library import candidates
from gmfbo.diagnosis.misfit import Misfit
from gmfbo.physics import CATALOGUE
from tests.diagnosis.planted_noise import opened, planted


def size_of(effect: str, parameter: str, true: float, sigma: float) -> float:
    """Size at which one effect alone fits recordings that hold it, under noise [rad]."""
    with opened(planted(sigma, {f"{effect}.{parameter}": true})) as case:
        start = candidates([effect], case.setting.excitation)[0]
        (found,) = confirm(case.misfit, case.base, [start])
        return float(found.hypothesis.effects[0].values[parameter])


def unplayed(misfit: Misfit, model: Fitted) -> None:
    return None


CASES = [
    ("actuator_dead_zone", "width", 0.2, 3e-4, 0.01, 0.25),
    ("actuator_dead_zone", "width", 0.1, 3e-4, 0.02, 0.25),
    # The quiet fit gains 24 in chi2: too little for any other law to be asked under noise.
    ("actuator_dead_zone", "width", 0.02, 6e-4, 0.15, 0.7),
    ("coulomb_friction", "level", 0.02, 1e-3, 0.05, 0.08),
]


@pytest.mark.parametrize(("effect", "parameter", "true", "sigma", "within", "off"), CASES)
def test_with_the_noise_played_the_size_is_right(
    effect: str, parameter: str, true: float, sigma: float, within: float, off: float
) -> None:
    assert size_of(effect, parameter, true, sigma) == pytest.approx(true, rel=within)


@pytest.mark.parametrize(("effect", "parameter", "true", "sigma", "within", "off"), CASES)
def test_without_it_a_smaller_size_is_found(
    effect: str,
    parameter: str,
    true: float,
    sigma: float,
    within: float,
    off: float,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Negative control: the noise bridges part of what is there."""
    monkeypatch.setattr(confirming, "under_noise", unplayed)
    found = size_of(effect, parameter, true, sigma)
    assert np.isfinite(found)
    assert found < (1.0 - off) * true


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
