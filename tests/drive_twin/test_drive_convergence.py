"""The fixed step is fine enough: halving it changes next to nothing."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.objective import METRICS, step_metrics
from tests.drive_twin.drive_runs import CORNERS, IDEAL_ENCODERS, NO_FRICTION, Drive

COUNT = 2.0 * np.pi / 4096
# Contact that hardly rebounds; an elastic one rattles at rest, and then follows rounding errors.
BACKLASH = {"gear.backlash": 1e-3}


def true_position(
    drive: Drive, gains: tuple[float, float], parameters: Mapping[str, float], substeps: int
) -> NDArray[np.float64]:
    run = drive.run({**IDEAL_ENCODERS, **parameters, "solver.substeps": substeps}, gains=gains)
    return run.signal("true_position")


@pytest.mark.parametrize("friction", [{}, NO_FRICTION], ids=["friction", "no friction"])
@pytest.mark.parametrize("gains", CORNERS)
def test_halving_the_step_moves_the_rigid_drive_by_less_than_a_microradian(
    drive: Drive, gains: tuple[float, float], friction: dict[str, float]
) -> None:
    coarse, fine = (true_position(drive, gains, friction, n) for n in (1, 2))
    assert np.abs(coarse - fine).max() < 1e-6


@pytest.mark.parametrize("friction", [{}, NO_FRICTION], ids=["friction", "no friction"])
@pytest.mark.parametrize("gains", CORNERS)
def test_halving_the_step_moves_a_drive_with_backlash_by_less_than_ten_microradians(
    drive: Drive, gains: tuple[float, float], friction: dict[str, float]
) -> None:
    coarse, fine = (true_position(drive, gains, {**BACKLASH, **friction}, n) for n in (1, 2))
    assert np.abs(coarse - fine).max() < 1e-5


def test_the_split_of_friction_and_motion_is_of_second_order(drive: Drive) -> None:
    """Two halvings divide the error by about 16; by 8 at least near the corner of friction."""
    during_motion = slice(100, 180)
    paths = [true_position(drive, (100.0, 6.0), {}, n)[during_motion] for n in (1, 2, 4, 8, 16)]
    errors = [float(np.abs(path - paths[-1]).max()) for path in paths[:3]]
    assert errors[0] / errors[2] > 8.0


def test_the_drive_without_friction_is_of_fourth_order(drive: Drive) -> None:
    paths = [true_position(drive, (30.0, 2.0), NO_FRICTION, n) for n in (1, 2, 8)]
    coarse, fine = (float(np.abs(path - paths[-1]).max()) for path in paths[:2])
    assert coarse / fine > 12.0


@pytest.mark.parametrize("gains", CORNERS)
def test_with_counting_encoders_the_first_difference_is_one_count(
    drive: Drive, gains: tuple[float, float]
) -> None:
    coarse, fine = (drive.run({"solver.substeps": n}, gains=gains) for n in (1, 2))
    apart = np.abs(coarse.signal("position") - fine.signal("position"))
    differing = np.flatnonzero(apart > 0.5 * COUNT)
    if differing.size:
        assert apart[differing[0]] == pytest.approx(COUNT, rel=1e-6)
    scored = [
        step_metrics(run.time, run.signal("position"), step_time=0.1, horizon=1.0)
        for run in (coarse, fine)
    ]
    for name in METRICS:
        np.testing.assert_allclose(scored[0][name], scored[1][name], rtol=5e-3, err_msg=name)


@pytest.mark.parametrize("gains", [(100.0, 6.0), (200.0, 10.0)])
def test_a_drive_with_ideal_encoders_comes_to_rest(
    drive: Drive, gains: tuple[float, float]
) -> None:
    run = drive.run(IDEAL_ENCODERS, gains=gains, duration=3.0)
    at_rest = slice(-500, None)
    assert np.ptp(run.signal("true_position")[at_rest]) < 1e-10
    assert np.ptp(run.signal("torque_command")[at_rest]) < 1e-8


@pytest.mark.parametrize("gains", CORNERS)
def test_a_drive_that_stands_does_not_chatter(drive: Drive, gains: tuple[float, float]) -> None:
    """Encoder counts may ring its presliding stiffness at 16 Hz, but no velocity flips each step.

    sqrt(1500 N.m/rad / 0.156 kg.m2) is 98 rad/s: 16 changes of sign in half a second.
    """
    velocity = drive.run({}, gains=gains, duration=3.0).signal("velocity")[-500:]
    assert np.count_nonzero(velocity[1:] * velocity[:-1] < 0.0) <= 25


def test_ten_short_communication_steps_are_one_long_step(drive: Drive) -> None:
    long = drive.run({}, step=1e-3, reference=np.where(np.arange(1101) >= 100, 1.0, 0.0))
    short = drive.run({}, step=1e-4, reference=np.where(np.arange(11001) >= 1000, 1.0, 0.0))
    for name in ("true_position", "torque_command", "i_q"):
        np.testing.assert_array_equal(long.signal(name), short.signal(name)[::10], err_msg=name)
