"""Left-out misfit of linear problems, against refits by hand; gains that chance alone gives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.hypothesis import Candidate, Hypothesis, Setting
from gmfbo.diagnosis.fitting.linear_left_out import normal_equations, sums_of_others
from gmfbo.diagnosis.fitting.misfit import Misfit
from gmfbo.diagnosis.naming.threshold import LEAST_THRESHOLD, NullGains, left_out_square
from gmfbo.diagnosis.screening.probes import Probe
from gmfbo.sources.twin.uncertain import Uncertain
from tests.physics.excitations import TYPICAL

Blocks = tuple[NDArray[np.float64], ...]


def linear_problem(
    rng: np.random.Generator, groups: int, columns: int, rows: int = 40
) -> tuple[Blocks, Blocks]:
    """Residuals and columns of as many windows as groups."""
    residual = tuple(rng.standard_normal(rows) for _ in range(groups))
    return residual, tuple(rng.standard_normal((columns, rows)) for _ in range(groups))


def refitted_without(
    residual: Blocks, columns: Blocks, prior: NDArray[np.float64], g: int
) -> float:
    """Square in group g after a ridge fit on all others, by least squares over stacked rows."""
    others = [i for i in range(len(residual)) if i != g]
    a = np.vstack([*(columns[i].T for i in others), np.diag(np.sqrt(prior))])
    b = np.concatenate([*(residual[i] for i in others), np.zeros(prior.size)])
    change = np.linalg.lstsq(a, b, rcond=None)[0]
    return float(np.sum((residual[g] - columns[g].T @ change) ** 2))


@given(st.integers(2, 6), st.integers(1, 4), st.integers(0, 2**32 - 1))
def test_the_square_left_out_is_that_of_a_refit_on_the_others(
    groups: int, columns: int, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    residual, sensitivity = linear_problem(rng, groups, columns)
    prior = rng.uniform(0.01, 10.0, columns)
    normal = normal_equations(residual, sensitivity, range(groups), prior)
    expected = [refitted_without(residual, sensitivity, prior, g) for g in range(groups)]
    np.testing.assert_allclose(normal.left_out(), expected, rtol=1e-7)


def test_columns_of_very_different_sizes_are_solved_alike() -> None:
    residual, sensitivity = linear_problem(np.random.default_rng(1), 4, 3)
    sizes = np.array([1e-9, 1.0, 1e9])
    plain = normal_equations(residual, sensitivity, range(4)).left_out()
    scaled = normal_equations(
        residual, tuple(sizes[:, None] * a for a in sensitivity), range(4)
    ).left_out()
    np.testing.assert_allclose(scaled, plain, rtol=1e-6)


def test_windows_of_one_group_are_left_out_together() -> None:
    residual, sensitivity = linear_problem(np.random.default_rng(2), 4, 2)
    normal = normal_equations(residual, sensitivity, [0, 0, 1, 1])
    joined = tuple(np.concatenate(residual[i : i + 2]) for i in (0, 2))
    stacked = tuple(np.concatenate(sensitivity[i : i + 2], axis=1) for i in (0, 2))
    np.testing.assert_allclose(
        normal.left_out(), normal_equations(joined, stacked, [0, 1]).left_out()
    )


def test_a_single_group_has_nothing_left_out_and_is_scored_by_its_own_fit() -> None:
    residual, sensitivity = linear_problem(np.random.default_rng(3), 1, 2)
    normal = normal_equations(residual, sensitivity, [0])
    np.testing.assert_allclose(normal.left_out(), normal.fitted())


def test_sums_of_others_lose_nothing_to_a_group_that_outweighs_them() -> None:
    values = np.array([1e12, 0.25, 0.5])
    np.testing.assert_array_equal(sums_of_others(values)[0], 0.75)


@dataclass(frozen=True)
class FlatWhitener:
    """Signals that are white already."""

    n_residuals: int


@dataclass(frozen=True, eq=False)
class FlatMisfit(Misfit):
    """Columns are whitened residuals, one tuple of a single signal a window."""

    def whitened(self, columns: list[list[NDArray[np.float64]]]) -> Blocks:  # type: ignore[override]
        return tuple(column[0] for column in columns)


@dataclass(frozen=True, eq=False)
class LinearCase:
    """A linear twin of two parameters, and probes of a library in the same space."""

    base: Fitted
    nulls: NullGains
    probes: list[Blocks]
    priors: list[NDArray[np.float64]]
    sizes: tuple[int, ...]


def linear_case(seed: int, windows: int = 4, rows: int = 60, library: int = 12) -> LinearCase:
    rng = np.random.default_rng(seed)
    own = tuple(rng.standard_normal((2, rows)) for _ in range(windows))
    setting = Setting((Uncertain("a", 1.0, 0.0, 2.0), Uncertain("b", 1.0, 0.0, 2.0)), TYPICAL)
    base = Fitted(
        Hypothesis(setting),
        np.ones(2),
        [],
        tuple(np.zeros(rows) for _ in range(windows)),
        own,
        [],
    )
    misfit = FlatMisfit.__new__(FlatMisfit)
    object.__setattr__(misfit, "whiteners", tuple(FlatWhitener(rows) for _ in range(windows)))
    tried, blocks, priors = [], [], []
    for _ in range(library):
        columns = tuple(rng.standard_normal((1, rows)) for _ in range(windows))
        probe = Probe(
            Candidate("constant_torque_offset", {"level": 1.0}),
            ("level",),
            (1.0,),
            (False,),
            [[(columns[k][0],) for k in range(windows)]],
            {"level": 1.0},
        )
        tried.append(probe)
        blocks.append(columns)
        priors.append(probe.prior)
    nulls = NullGains(misfit, base, tried, range(windows))
    return LinearCase(base, nulls, blocks, priors, (rows,) * windows)


def test_the_largest_gain_of_a_draw_is_that_of_refits_by_hand() -> None:
    case, rng = linear_case(0), np.random.default_rng(1)
    draws = tuple(rng.standard_normal((size, 3)) for size in case.sizes)
    found = case.nulls.largest(draws)
    for d in range(3):
        residual = tuple(block[:, d] for block in draws)
        gains = []
        for columns, prior in zip(case.probes, case.priors, strict=True):
            together = tuple(
                np.concatenate([a, b]) for a, b in zip(case.base.sensitivity, columns, strict=True)
            )
            both = np.concatenate([case.base.prior, prior])
            before = normal_equations(residual, case.base.sensitivity, range(4), case.base.prior)
            after = normal_equations(residual, together, range(4), both)
            gains.append(
                min(
                    before.left_out().sum() - after.left_out().sum(),
                    before.fitted().sum() - after.fitted().sum(),
                )
            )
        assert found[d] == pytest.approx(max(gains), rel=1e-9)


def test_chance_exceeds_the_threshold_about_once_in_a_hundred_draws() -> None:
    """The 99 % quantile of 200 draws: fresh draws exceed it in 0.1-3 % (99.9 % of seeds)."""
    case, rng = linear_case(2), np.random.default_rng(3)
    draws = tuple(rng.standard_normal((size, 200)) for size in case.sizes)
    threshold = float(np.quantile(case.nulls.largest(draws), 0.99))
    fresh = tuple(rng.standard_normal((size, 4000)) for size in case.sizes)
    share = float(np.mean(case.nulls.largest(fresh) > threshold))
    assert 0.001 < share < 0.03


def test_the_threshold_is_never_below_its_least() -> None:
    assert linear_case(4).nulls.threshold(np.random.default_rng(0)) >= LEAST_THRESHOLD


def test_a_library_without_effects_has_the_least_threshold() -> None:
    case = linear_case(5, library=0)
    assert case.nulls.threshold(np.random.default_rng(0)) == LEAST_THRESHOLD


def test_left_out_squares_of_a_fit_are_those_of_its_normal_equations() -> None:
    case, rng = linear_case(6), np.random.default_rng(7)
    residual = tuple(rng.standard_normal(size) for size in case.sizes)
    fitted = Fitted(case.base.hypothesis, case.base.x, [], residual, case.base.sensitivity, [])
    expected = [
        refitted_without(residual, case.base.sensitivity, case.base.prior, g) for g in range(4)
    ]
    np.testing.assert_allclose(left_out_square(fitted, range(4)), expected, rtol=1e-7)
