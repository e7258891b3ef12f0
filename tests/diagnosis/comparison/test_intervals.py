"""Intervals of a linear fit under white noise, against what is known."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import multivariate_normal, norm

from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.held_out_fit import Part
from gmfbo.diagnosis.comparison.priors import Prior
from gmfbo.diagnosis.comparison.whitener import Whitening

ROWS, STRETCH = 360, 30
WIDE = Prior(-50.0, 50.0, False, "normal", 0.0, 30.0)


class White:
    """Signals that are white already."""

    log_determinants = (np.zeros(ROWS),)

    def __call__(self, values: list[NDArray[np.float64]]) -> list[NDArray[np.float64]]:
        return values

    def about(self, names: object, columns: object) -> White:
        """Of one recording, in which nothing has an own part."""
        return self


@dataclass(frozen=True)
class Run:
    """A run of the twin, which tells its signals."""

    signals: tuple[NDArray[np.float64], ...] = ()


def linear_part(
    rng: np.random.Generator,
    columns: NDArray[np.float64],
    size: float,
    late: NDArray[np.float64] | None = None,
) -> Part:
    """Least squares for unit values under noise of this size; columns have shape (p, rows).

    What the step makes of the simulation moves values by as much as `late` says.
    """
    noisy = columns.T @ np.ones(len(columns)) + size * rng.standard_normal(ROWS)
    changes = None if late is None else (0.5 * columns.T @ late,)
    if late is not None:
        noisy = noisy + columns.T @ late
    x = np.linalg.lstsq(columns.T, noisy, rcond=None)[0].astype(np.float64)
    fitted = Fitted(
        cast(Any, SimpleNamespace(names=())),
        (),
        (WIDE,) * len(columns),
        x,
        np.zeros(0),
        [],
        [],
        [(noisy - columns.T @ x)[None]],
        [columns[:, None]],
        True,
        np.zeros(0, dtype=bool),
    )
    stretches = [[slice(a, a + STRETCH) for a in range(0, ROWS, STRETCH)]]
    problem = SimpleNamespace(
        stretches=lambda: stretches,
        point=lambda *values: None,
        values=lambda runs: [run.signals[0][None] for run in runs],
        simulations=SimpleNamespace(
            run=lambda points: [[Run()]], step_errors=lambda point, runs: [changes]
        ),
    )
    return Part(cast(Any, problem), cast(Whitening, White()), fitted)


def test_intervals_hold_the_truth_in_about_95_of_100_fits() -> None:
    """Of 300 fits with two values; the larger of two intervals holds somewhat more."""
    rng = np.random.default_rng(3)
    columns = rng.standard_normal((2, ROWS))
    inside = []
    for _ in range(300):
        _, low, high = linear_part(rng, columns, 1.0).intervals()
        inside.append((low < 1.0) & (high > 1.0))
    assert 0.93 < np.mean(inside) < 0.995


def test_intervals_widen_with_what_the_model_leaves() -> None:
    columns = np.random.default_rng(4).standard_normal((2, ROWS))
    one, three = (
        linear_part(np.random.default_rng(5), columns, size).intervals()[0] for size in (1.0, 3.0)
    )
    np.testing.assert_allclose(three / one, 3.0, rtol=0.3)


def test_nothing_free_has_no_intervals() -> None:
    part = linear_part(np.random.default_rng(6), np.zeros((0, ROWS)), 1.0)
    assert all(ends.size == 0 for ends in part.intervals())


def test_intervals_reach_to_the_values_of_an_infinitely_short_step() -> None:
    """A step that raises the first value by ten standard deviations and lowers the other."""
    columns = np.random.default_rng(6).standard_normal((2, ROWS))
    late = np.array([0.5, -0.5])
    _, low, high = linear_part(np.random.default_rng(7), columns, 1.0).intervals()
    _, late_low, late_high = linear_part(np.random.default_rng(7), columns, 1.0, late).intervals()
    np.testing.assert_allclose(late_high[0] - late[0], high[0], rtol=1e-3)
    np.testing.assert_allclose(late_low[0], low[0], rtol=1e-3)
    np.testing.assert_allclose(late_high[1], high[1], rtol=1e-3)
    np.testing.assert_allclose(late_low[1] - late[1], low[1], rtol=1e-3)


def with_mode(part: Part, shift: float, worse: float) -> Part:
    """The same with another fit beside it, whose whitened square is larger by so much."""
    left = part.fitted.residual[0]
    share = np.sqrt(1.0 + worse / np.sum(left**2))
    other = replace(part.fitted, u=part.fitted.u + shift, residual=[share * left])
    return replace(part, modes=(other,))


def test_two_fits_as_good_are_both_within_the_interval() -> None:
    columns = np.random.default_rng(6).standard_normal((2, ROWS))
    part = linear_part(np.random.default_rng(7), columns, 1.0)
    deviation, low, high = part.intervals()
    more, both_low, both_high = with_mode(part, 20.0 * deviation[0], 0.0).intervals()
    # 2.5 % of a mixture of halves are 5 % of one of them: 1.645 deviations.
    inward = (1.96 - 1.645) * deviation
    np.testing.assert_allclose(both_low, low + inward, atol=0.1 * deviation[0])
    np.testing.assert_allclose(
        both_high, high - inward + 20.0 * deviation[0], atol=0.1 * deviation[0]
    )
    assert np.all(more > 4.0 * deviation)


def test_a_fit_that_is_far_worse_does_not_widen_the_interval() -> None:
    columns = np.random.default_rng(6).standard_normal((2, ROWS))
    part = linear_part(np.random.default_rng(7), columns, 1.0)
    deviation, low, high = part.intervals()
    _, own_low, own_high = with_mode(part, 20.0 * deviation[0], 60.0).intervals()
    np.testing.assert_allclose(own_low, low, atol=0.1 * deviation[0])
    np.testing.assert_allclose(own_high, high, atol=0.1 * deviation[0])


def test_odds_that_values_lie_elsewhere_are_those_of_two_evidences() -> None:
    """Of a linear fit the evidence is a normal density of all rows (Bishop 2006, eq. 3.86).

    Told are no more where they count: widths allow for stretches that speak for other values.
    """
    rng = np.random.default_rng(5)
    columns = rng.standard_normal((2, ROWS))
    part = linear_part(rng, columns, 1.0)
    rows = part.fitted.residual[0][0] + columns.T @ part.fitted.u
    spread = np.eye(ROWS) + WIDE.spread**2 * columns.T @ columns
    whole = multivariate_normal(np.zeros(ROWS), spread).logpdf(rows)
    assert part.log_odds_against(part.fitted.u) < 0.0
    for apart in (0.4, 0.6):
        values = part.fitted.u + apart
        exact = whole - np.sum(norm.logpdf(rows - columns.T @ values))
        told = part.log_odds_against(values)
        assert told < exact + 0.1
        assert told == pytest.approx(exact, rel=0.3)


def test_odds_stand_quantities_of_any_units_and_such_as_are_nearly_the_same() -> None:
    rng = np.random.default_rng(6)
    columns = rng.standard_normal((2, ROWS))
    plain = linear_part(rng, columns, 1.0).log_odds_against(np.array([1.0, 2.0]))
    assert plain > 10.0
    steep = linear_part(np.random.default_rng(7), columns * [[1.0], [1e7]], 1.0)
    assert steep.log_odds_against(np.array([1.0, 2.0])) > 10.0
    alike = linear_part(rng, np.stack([columns[0], columns[0] + 1e-7 * columns[1]]), 1.0)
    assert np.isfinite(alike.log_odds_against(alike.fitted.u))


def test_one_quantity_that_lies_elsewhere_is_not_hidden_by_many_that_do_not() -> None:
    columns = np.random.default_rng(8).standard_normal((8, ROWS))
    part = linear_part(np.random.default_rng(9), columns, 1.0)
    values = part.fitted.u.copy()
    assert part.log_odds_against(values) < 0.0
    values[3] += 0.35  # seven deviations; eight quantities cost six nats each
    assert part.log_odds_against(values) > 5.0
