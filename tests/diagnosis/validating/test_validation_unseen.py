"""Recordings given for validation are scored and never fitted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache

import numpy as np
import pytest

from gmfbo import diagnose
from gmfbo.diagnosis.diagnosis import Diagnosis
from gmfbo.errors import RecordingError
from gmfbo.physics import CATALOGUE
from gmfbo.recordings.recording import Recording
from tests.diagnosis.short_recordings import SERVO, moves, multisine, named, triangle

FRICTION = {"coulomb_friction.level": 0.25, "coulomb_friction.deflection": 1e-6}
DELAYED = {"transport_delay.delay": 4e-3}
FEW = ("coulomb_friction", "transport_delay")


@cache
def recorded(physics: tuple[tuple[str, float], ...]) -> list[Recording]:
    """Recordings of a multisine, moves and a triangle."""
    return SERVO.recordings(dict(physics), (multisine, moves, triangle))


def three(physics: Mapping[str, float]) -> list[Recording]:
    return recorded(tuple(physics.items()))


def diagnosed_on(
    fitted: Sequence[Recording], unseen: Sequence[Recording] | None = None
) -> Diagnosis:
    excluded = [name for name in CATALOGUE if name not in FEW]
    return diagnose(SERVO.twin(), fitted, unseen, exclude=excluded, jobs=1)


@pytest.fixture(scope="module")
def unseen() -> Diagnosis:
    recordings = three(FRICTION)
    return diagnosed_on(recordings[:2], recordings[2:])


def values(diagnosis: Diagnosis) -> dict[str, float]:
    """Everything that was fitted."""
    found = {name: estimate.value for name, estimate in diagnosis.parameters.items()}
    for effect in diagnosis.effects:
        found |= {f"{effect.name}.{n}": v.value for n, v in effect.parameters.items()}
    return found


def test_exactly_the_given_recordings_are_held_out_and_all_others_fitted(
    unseen: Diagnosis,
) -> None:
    assert unseen.fit.held_out == ("rec2.csv",)
    assert unseen.fit.fitted_on == ("rec0.csv", "rec1.csv")
    assert {curve.recording for curve in unseen.curves} == {"rec2.csv"}


def test_the_physics_carries_over_to_what_was_not_seen(unseen: Diagnosis) -> None:
    assert named(unseen) == ["coulomb_friction"]
    removed = unseen.fit.explainable_error_removed
    assert removed is not None
    assert removed > 0.99
    gain, error = unseen.fit.log_density_gain, unseen.fit.gain_error
    assert gain is not None
    assert error is not None
    # Few stretches hold most of it: even so clear a gain is hardly two standard errors.
    assert gain > error > 1e4
    for fit in unseen.fit.signals.values():
        assert fit.augmented < 0.3 * fit.parameters_only
        assert fit.augmented < 1.5 * fit.noise_floor


def test_the_noise_floor_of_what_was_not_seen_is_that_of_its_noise(unseen: Diagnosis) -> None:
    for fit in unseen.fit.signals.values():
        assert np.isfinite(fit.noise_floor)
        assert fit.noise_floor > 0.0
    position = three(FRICTION)[2].signals["position"]
    # The controller rejects some of the sensor's noise, and what is read holds it whole.
    expected = SERVO.noise["position"] / np.ptp(position)
    assert unseen.fit.signals["position"].noise_floor == pytest.approx(expected, rel=0.25)


def test_what_is_validated_on_moves_no_fitted_value(unseen: Diagnosis) -> None:
    """Other physics there leaves the same model, which scores worse."""
    other = diagnosed_on(three(FRICTION)[:2], three({**FRICTION, **DELAYED})[2:])
    assert values(other) == values(unseen)
    assert [e.evidence for e in other.effects] == [e.evidence for e in unseen.effects]
    for name, fit in other.fit.signals.items():
        assert fit.augmented > unseen.fit.signals[name].augmented


def test_the_augmented_twin_is_the_fit_to_all_that_was_given_to_fit(unseen: Diagnosis) -> None:
    assert unseen.augmentation is not None
    fitted = {physics.name: physics.value for physics in unseen.augmentation.physics}
    reported = unseen.effects[0].parameters["level"].value
    assert fitted["coulomb_friction.level"] == pytest.approx(reported, rel=1e-12)
    for name, estimate in unseen.parameters.items():
        assert unseen.augmentation.parameters[name] == pytest.approx(estimate.value, rel=1e-12)


@pytest.mark.slow
def test_without_recordings_to_validate_on_parts_of_the_same_are_kept_back(
    unseen: Diagnosis,
) -> None:
    within = diagnosed_on(three(FRICTION)[:2])
    assert named(within) == named(unseen)
    assert within.fit.held_out
    assert not set(within.fit.held_out) & {"rec0.csv", "rec1.csv", "rec2.csv"}
    level = within.effects[0].parameters["level"]
    assert level.low <= unseen.effects[0].parameters["level"].value <= level.high


def test_where_nothing_is_missing_the_refitted_twin_alone_is_scored() -> None:
    recordings = three({})
    diagnosis = diagnosed_on(recordings[:1], recordings[1:])
    assert diagnosis.effects == ()
    assert diagnosis.fit.held_out == ("rec1.csv", "rec2.csv")
    assert diagnosis.fit.explainable_error_removed is None
    assert diagnosis.fit.log_density_gain is None
    for fit in diagnosis.fit.signals.values():
        assert np.isnan(fit.augmented)
        assert fit.parameters_only < 1.2 * fit.noise_floor


def test_a_short_recording_to_validate_on_is_refused_by_name() -> None:
    recordings = three(FRICTION)
    short = SERVO.recordings(FRICTION, (multisine,), seconds=0.05)
    with pytest.raises(RecordingError, match=r"^rec0\.csv: expected at least 64 rows"):
        diagnosed_on(recordings[:1], short)
