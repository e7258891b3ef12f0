"""From a diagnosis with rivals to the reference that tells them apart, and to what came of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gmfbo import FmuTwin, Recording
from gmfbo.diagnosis.diagnosis import Diagnosis
from gmfbo.diagnosis.experiment.play_limits import PlayLimits, largest_rates
from gmfbo.diagnosis.experiment.predicted_against_observed import confirm_with
from gmfbo.diagnosis.experiment.proposal import ProposedExperiment
from gmfbo.diagnosis.experiment.within_limits import propose_experiment
from gmfbo.diagnosis.result.predictions import PARAMETERS_ONLY, Explanation
from gmfbo.errors import InputError
from gmfbo.sources.fmu_file.models import models_folder
from tests.diagnosis.compensation.compensation_cases import diagnosis_of
from tests.diagnosis.short_recordings import SERVO, SERVO_TRUTH, multisine

RIVALS = ("elastic_return", "gravity_torque")
LIMITS = PlayLimits(-1.2, 1.2, 12.0, 300.0, 4.0, jerk=2e4, torque=4.0)
SPRING = {"elastic_return.stiffness": 0.3}
ROUNDING = 1.0 + 1e-6


@pytest.fixture(scope="module")
def rivals() -> Diagnosis:
    """A spring and a pendulum: one as good as the other along small angles."""
    found = diagnosis_of({"elastic_return": {"stiffness": 0.3, "preload": 0.0}})
    assert found.predictions is not None
    values = SERVO_TRUTH
    spring = Explanation("elastic_return", ("elastic_return",), values, SPRING, 1.0)
    pendulum = {"gravity_torque.sine": -0.297, "gravity_torque.cosine": 0.0}
    weight = Explanation("gravity_torque", ("gravity_torque",), values, pendulum, 1.0)
    spring = replace(spring, physics={**SPRING, "elastic_return.preload": 0.0})
    plain = Explanation(PARAMETERS_ONLY, (), values, {}, 60.0)
    return replace(
        found, predictions=replace(found.predictions, explanations=(spring, weight, plain))
    )


@pytest.fixture(scope="module")
def proposed(rivals: Diagnosis) -> ProposedExperiment:
    with SERVO.twin() as twin:
        return propose_experiment(twin, LIMITS, rivals, jobs=2)


def played(proposed: ProposedExperiment, physics: dict[str, float]) -> Recording:
    """The axis with this physics, playing what was proposed."""
    values = proposed.recording.signal("reference")
    seconds = values.size * 1e-3
    (recording,) = SERVO.recordings(physics, (lambda t: values[: t.size],), seconds=seconds, seed=6)
    return recording


def test_it_is_chosen_to_tell_the_rivals_apart(proposed: ProposedExperiment) -> None:
    assert set(proposed.rivals) == set(RIVALS)
    assert proposed.separation is not None
    assert set(proposed.separation.told_apart) == {RIVALS}
    assert set(proposed.predicted) == set(RIVALS)


def test_it_keeps_its_limits_and_rests_at_both_ends(proposed: ProposedExperiment) -> None:
    recording = proposed.recording
    values = recording.signal("reference")
    assert recording.time[-1] - recording.time[0] <= LIMITS.duration
    assert LIMITS.low <= values.min() < values.max() <= LIMITS.high
    for name, largest in largest_rates(values, 1e-3).items():
        assert largest <= LIMITS.rate(name) * ROUNDING
    assert np.ptp(values[:4]) == pytest.approx(0.0, abs=1e-12)
    assert np.ptp(values[-4:]) == pytest.approx(0.0, abs=1e-9)


def test_the_axis_stays_within_them_in_an_independent_simulation(
    proposed: ProposedExperiment,
) -> None:
    with SERVO.twin() as twin:
        run = twin.run({}, proposed.recording)
    assert np.abs(run.signal("torque_command")).max() <= LIMITS.torque * ROUNDING
    assert LIMITS.low <= run.signal("position").min()
    assert run.signal("position").max() <= LIMITS.high


@pytest.mark.parametrize(
    ("physics", "name"),
    [(SPRING, "elastic_return"), ({"gravity_torque.sine": -0.297}, "gravity_torque"), ({}, None)],
)
def test_once_it_is_played_the_true_one_is_supported(
    rivals: Diagnosis,
    proposed: ProposedExperiment,
    physics: dict[str, float],
    name: str | None,
) -> None:
    with SERVO.twin() as twin:
        told = confirm_with(twin, rivals, played(proposed, physics), jobs=2)
    assert told.best.name == (name or PARAMETERS_ONLY)
    assert told.outcome == "supports"
    assert told.best.per_residual < 2.0
    assert {p.name for p in told.predictions} == {*RIVALS, PARAMETERS_ONLY}


def test_along_small_angles_both_fit(rivals: Diagnosis) -> None:
    """What the rivals were left by: no answer is made up where there is none."""
    (recording,) = SERVO.recordings(SPRING, (lambda t: 0.1 * multisine(t),), seed=6)
    with SERVO.twin() as twin:
        told = confirm_with(twin, rivals, recording, jobs=2)
    assert told.outcome == "cannot_tell"
    assert {p.name for p in told.alike} >= set(RIVALS)


def test_an_axis_that_is_neither_supports_none(
    rivals: Diagnosis, proposed: ProposedExperiment
) -> None:
    """Negative control: friction, which no rival has."""
    with SERVO.twin() as twin:
        told = confirm_with(twin, rivals, played(proposed, {"coulomb_friction.level": 0.3}), jobs=2)
    assert told.outcome == "none"
    assert "supports none of them" in told.sentence


def test_a_column_that_is_off_by_its_nuisances_does_not_count_against_a_prediction(
    rivals: Diagnosis, proposed: ProposedExperiment
) -> None:
    """A torque sensor's scale that is 3 % off is fitted to the first third, and then known."""
    recording = played(proposed, SPRING)
    scaled = {**recording.signals, "torque_command": 1.03 * recording.signal("torque_command")}
    with SERVO.twin() as twin:
        plain = confirm_with(twin, rivals, recording, jobs=2)
        told = confirm_with(twin, rivals, replace(recording, signals=scaled), jobs=2)
    assert told.best.name == plain.best.name
    assert told.best.per_residual < 1.5 * plain.best.per_residual + 0.5


def test_without_a_diagnosis_it_shows_most_of_the_library() -> None:
    with SERVO.twin() as twin:
        found = propose_experiment(twin, LIMITS, jobs=2)
    assert {"coulomb_friction", "backlash", "transport_delay"} <= set(found.shows)
    assert found.shows["coulomb_friction"].size < 0.02
    assert found.rivals == ()
    assert found.predicted == {}


def test_what_was_not_excited_is_what_it_is_chosen_for() -> None:
    from gmfbo.diagnosis.result.named_effect import NotTestable

    silent = (NotTestable("backlash", "not excited: no reversal of the velocity"),)
    with SERVO.twin() as twin:
        found = propose_experiment(
            twin, LIMITS, replace(diagnosis_of({}), not_testable=silent), jobs=2
        )
    assert found.wanted == ("backlash",)


def test_a_plant_without_a_controller_gets_an_experiment_too() -> None:
    limits = PlayLimits(-0.5, 0.5, 8.0, 200.0, 4.0)
    with FmuTwin(models_folder() / "motor_bench.toml") as twin:
        found = propose_experiment(twin, limits, jobs=2)
        run = twin.run({}, found.recording)
    assert list(found.recording.signals) == ["current"]
    assert found.recording.units == {"current": "A"}
    assert -0.5 <= run.signal("position").min() < run.signal("position").max() <= 0.5
    assert "coulomb_friction" in found.shows


def test_a_diagnosis_of_another_twin_is_refused(rivals: Diagnosis) -> None:
    told = rivals.predictions
    assert told is not None
    first = replace(told.explanations[0], parameters={"mech.J": 0.1})
    other = replace(rivals, predictions=replace(told, explanations=(first,)))
    recording = Recording(time=np.arange(3000.0) * 1e-3, signals={})
    with SERVO.twin() as twin, pytest.raises(InputError, match="is of another twin than"):
        confirm_with(twin, other, recording)


def test_an_axis_that_stands_outside_its_limits_is_refused() -> None:
    with SERVO.twin() as twin, pytest.raises(InputError, match="stands at 0 and the limits"):
        propose_experiment(twin, replace(LIMITS, low=0.1))
