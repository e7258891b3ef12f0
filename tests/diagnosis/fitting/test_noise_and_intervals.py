"""Noise under motion, and intervals of linear fits, against what is known."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.hypothesis import Hypothesis, Setting
from gmfbo.diagnosis.fitting.intervals import combinations_of
from gmfbo.diagnosis.runs.scored_record import ScoredSignal
from gmfbo.diagnosis.scoring.noise_levels import noise_level, white_covariance
from gmfbo.diagnosis.scoring.whitening import make_window
from gmfbo.sources.twin.uncertain import Uncertain
from tests.physics.excitations import TYPICAL

STEP = 1e-3


def signal_of(values: NDArray[np.float64], resolution: float = 0.0) -> ScoredSignal:
    time = np.arange(values.size, dtype=np.float64) * STEP
    return ScoredSignal("position", time, values, resolution)


@pytest.mark.parametrize("sigma", [1e-5, 1e-2])
def test_white_noise_is_found_under_a_motion_ten_thousand_times_its_size(sigma: float) -> None:
    """The estimate's own spread is 5 %: 360 bins, of which the median is taken."""
    rng, t = np.random.default_rng(0), np.arange(2000) * STEP
    motion = 1e4 * sigma * (np.sin(6.0 * t) + 0.3 * np.sin(30.0 * t + 1.0) + t)
    values = motion + sigma * rng.standard_normal(t.size)
    assert noise_level(signal_of(values), values).total == pytest.approx(sigma, rel=0.15)


def test_a_single_fast_line_is_not_noise() -> None:
    rng, t = np.random.default_rng(1), np.arange(2000) * STEP
    values = 1e-3 * rng.standard_normal(t.size) + 0.1 * np.sin(2.0 * np.pi * 400.0 * t)
    assert noise_level(signal_of(values), values).total == pytest.approx(1e-3, rel=0.2)


def test_an_encoder_is_never_finer_than_its_counts() -> None:
    still = np.zeros(2000)
    still[1000:] = 1e-3
    level = noise_level(signal_of(still, resolution=1e-3), np.zeros(2000))
    assert level.total == level.least == pytest.approx(1e-3 / np.sqrt(12.0))


def test_counts_that_are_finer_than_a_simulation_is_right_leave_its_own_errors() -> None:
    """The EMPS' axis counts 50 nm of 0.25 m: lines were seen in what the twin computes."""
    motion = 0.125 * np.sin(np.arange(2000) * 3e-3)
    counted = noise_level(signal_of(motion, resolution=5e-8), np.zeros(2000))
    assert counted == noise_level(signal_of(motion), np.zeros(2000))
    assert counted.least > 5e-8


def test_the_covariance_of_white_noise_is_that_of_its_tapered_spectra() -> None:
    rng = np.random.default_rng(2)
    window = make_window(0, [STEP], [slice(0, 1000)])
    spectra = window.spectra([3.0 * rng.standard_normal((4000, 1000))])
    power = np.mean(np.abs(spectra[:, 5:, 0]) ** 2)
    assert power == pytest.approx(white_covariance(window, [9.0])[0, 0, 0].real, rel=0.01)


OWN = (Uncertain("a", 1.0, -50.0, 50.0), Uncertain("b", 1.0, -50.0, 50.0))


def linear_fit(rng: np.random.Generator, columns: list[NDArray[np.float64]]) -> Fitted:
    """Least squares for unit parameters under unit noise; one block a window."""
    noisy = [c.T @ np.ones(2) + rng.standard_normal(c.shape[1]) for c in columns]
    x: NDArray[np.float64] = np.linalg.lstsq(
        np.hstack(columns).T, np.concatenate(noisy), rcond=None
    )[0].astype(np.float64)
    residual = tuple(y - c.T @ x for y, c in zip(noisy, columns, strict=True))
    return Fitted(Hypothesis(Setting(OWN, TYPICAL)), x, [], residual, tuple(columns), [])


@pytest.mark.parametrize(("power", "expression"), [(-1.0, "a / b"), (1.0, "a * b")])
def test_what_trades_off_is_reported_as_the_combination_that_is_seen(
    power: float, expression: str
) -> None:
    """Signals that depend on a * b^power alone tell that product."""
    rng = np.random.default_rng(5)
    x = np.array([2.0, 3.0])
    seen = rng.standard_normal(80)
    # d/dln a and d/dln b of ln(a b^power) are 1 and power.
    sensitivity = np.stack([seen / x[0], power * seen / x[1]])
    fitted = Fitted(
        Hypothesis(Setting(OWN, TYPICAL)),
        x,
        [],
        (rng.standard_normal(80),),
        (sensitivity,),
        [],
    )
    (found,) = combinations_of(fitted)
    assert {*found.expression.split()} - {"*", "/"} == {"a", "b"}
    assert ("*" in found.expression) == ("*" in expression)
    first, sign, second = found.expression.split()
    values = {"a": x[0], "b": x[1]}
    product = values[first] * values[second] ** (1.0 if sign == "*" else -1.0)
    assert found.value == pytest.approx(product)
    assert found.low < found.value < found.high
