"""Samples of the corrected twin: where they lie, which are taken, and when drawing ends."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from gmfbo.correction.local_samples import (
    SamplingSettings,
    draw_local_samples,
    into_box,
    reference_size,
)
from gmfbo.correction.trajectory_gp import Pair, TrajectoryCorrection
from gmfbo.errors import InputError

TIME = np.linspace(0.0, 1.0, 201)
ALPHA = 0.95


def twin(point: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    return TIME, 1.0 - np.exp(-(4.0 + 4.0 * point[0]) * TIME)


@pytest.fixture(scope="module")
def correction() -> TrajectoryCorrection:
    simulated = twin(np.array([0.5, 0.5]))[1]
    return TrajectoryCorrection.fit([Pair(TIME, simulated, 0.9 * simulated + 0.05)])


def test_same_generator_gives_the_same_samples(correction: TrajectoryCorrection) -> None:
    first, second = (
        draw_local_samples(
            [0.5, 0.5], twin, correction, ALPHA, SamplingSettings(), np.random.default_rng(3)
        )
        for _ in range(2)
    )
    assert len(first.accepted) == 4
    for one, other in zip(first.draws, second.draws, strict=True):
        np.testing.assert_array_equal(one.point, other.point)
        np.testing.assert_array_equal(one.corrected, other.corrected)


def test_samples_carry_what_the_twin_said_and_what_became_of_it(
    correction: TrajectoryCorrection,
) -> None:
    samples = draw_local_samples(
        [0.5, 0.5], twin, correction, ALPHA, SamplingSettings(), np.random.default_rng(4)
    )
    for draw in samples.accepted:
        np.testing.assert_array_equal(draw.simulated, twin(draw.point)[1])
        np.testing.assert_allclose(draw.corrected, 0.9 * draw.simulated + 0.05, atol=2e-3)
        assert draw.sigma_c == pytest.approx(np.sqrt(np.mean(draw.std**2)))
        assert draw.sigma_c <= 0.05 * ALPHA


def test_draws_have_the_published_spread(correction: TrajectoryCorrection) -> None:
    settings = SamplingSettings(count=400, most_draws=400)
    samples = draw_local_samples(
        [0.5, 0.5], twin, correction, ALPHA, settings, np.random.default_rng(5)
    )
    assert not [d for d in samples.draws if not d.accepted]
    offsets = np.array([draw.point - 0.5 for draw in samples.draws])
    # 400 draws: the standard error of a standard deviation is 3.5 %, so this fails by chance
    # once in 10^4 runs of another seed.
    np.testing.assert_allclose(offsets.std(axis=0), 0.05, rtol=0.14)
    np.testing.assert_allclose(offsets.mean(axis=0), 0.0, atol=0.01)


def test_unsure_draws_come_nearer_and_end_after_the_last_one(
    correction: TrajectoryCorrection,
) -> None:
    settings = SamplingSettings(tolerance=1e-12, most_draws=20)
    samples = draw_local_samples(
        [0.5, 0.5], twin, correction, ALPHA, settings, np.random.default_rng(6)
    )
    assert len(samples.draws) == 20
    assert len([d for d in samples.draws if not d.accepted]) == 20
    distance = [float(np.linalg.norm(draw.point - 0.5)) for draw in samples.draws]
    assert max(distance[-5:]) < 0.1 * max(distance[:5])


def test_failed_simulations_are_counted_and_left_out(correction: TrajectoryCorrection) -> None:
    calls = []

    def every_other(
        point: NDArray[np.float64],
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
        calls.append(point)
        return twin(point) if len(calls) % 2 == 0 else None

    samples = draw_local_samples(
        [0.5, 0.5], every_other, correction, ALPHA, SamplingSettings(), np.random.default_rng(7)
    )
    assert len(samples.accepted) == 4
    assert samples.failed == 4


@pytest.mark.parametrize("at_border", ["project", "reflect"])
@given(point=st.lists(st.floats(-3.0, 4.0), min_size=1, max_size=5))
def test_points_are_brought_into_the_box(at_border: str, point: list[float]) -> None:
    given_point = np.array(point)
    inside = into_box(given_point, at_border)
    assert np.all((inside >= 0.0) & (inside <= 1.0))
    already = (given_point >= 0.0) & (given_point <= 1.0)
    np.testing.assert_allclose(inside[already], given_point[already], atol=1e-15)


def test_projection_goes_to_the_face_and_reflection_folds_back() -> None:
    np.testing.assert_allclose(into_box(np.array([-0.03, 1.02]), "project"), [0.0, 1.0])
    np.testing.assert_allclose(into_box(np.array([-0.03, 1.02]), "reflect"), [0.03, 0.98])


def test_reference_size_of_the_published_step() -> None:
    time = np.arange(1101) * 1e-3
    step = (time >= 0.1).astype(float)
    assert reference_size(step) == pytest.approx(np.sqrt(1001 / 1101))
    assert reference_size(np.array([np.nan, 3.0, 4.0])) == pytest.approx(np.sqrt(12.5))


def test_impossible_requests_are_refused(correction: TrajectoryCorrection) -> None:
    rng = np.random.default_rng(0)
    with pytest.raises(InputError, match="point in the unit cube"):
        draw_local_samples([1.2, 0.5], twin, correction, ALPHA, SamplingSettings(), rng)
    with pytest.raises(InputError, match="positive size of the reference"):
        draw_local_samples([0.5, 0.5], twin, correction, 0.0, SamplingSettings(), rng)
