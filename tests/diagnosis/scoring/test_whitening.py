"""Residuals of known covariance become white; what is a nuisance is left out."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.hypothesis import Hypothesis, Setting
from gmfbo.diagnosis.scoring.noise_levels import power_beside, white_covariance
from gmfbo.diagnosis.scoring.whitening import Whitener, Window, make_window
from tests.physics.excitations import TYPICAL

STEP = 1e-3


def window_of(rows: int = 2000, every: int = 1) -> Window:
    """Window over two signals, the second sampled every so many milliseconds."""
    spacings = (STEP, every * STEP)
    return make_window(0, spacings, [slice(0, rows), slice(0, rows // every)])


def correlated(window: Window) -> NDArray[np.complex128]:
    """Covariance of white noise of the two signals that share half of the smaller one."""
    s = white_covariance(window, [4.0, 1.0])
    shared = 0.5 * np.sqrt(s[:, 0, 0] * s[:, 1, 1])
    s[:, 0, 1] = s[:, 1, 0] = shared
    return s


def coloured(window: Window, rng: np.random.Generator, count: int) -> list[NDArray[np.float64]]:
    """Draws of that noise, shape (count, rows) a signal."""
    rows = window.rows[0].stop
    a, b = rng.standard_normal((2, count, rows))
    return [2.0 * a, 0.5 * a + np.sqrt(0.75) * b]


def test_noise_of_the_stated_covariance_has_a_chi2_of_one_a_degree_of_freedom() -> None:
    window, rng, count = window_of(), np.random.default_rng(0), 200
    whitener = Whitener(window, correlated(window))
    residual = whitener.whiten(coloured(window, rng, count))
    assert residual.shape == (count, whitener.n_residuals)
    chi2 = np.sum(residual**2, axis=1) / whitener.n_residuals
    # The taper correlates neighbouring bins, so the spread is taken from the draws themselves.
    error = chi2.std() / np.sqrt(count)
    assert abs(chi2.mean() - 1.0) < 4.0 * error < 0.02


def test_each_component_is_of_unit_variance_and_signals_are_independent() -> None:
    window, rng = window_of(), np.random.default_rng(1)
    white = Whitener(window, correlated(window)).colour(window.spectra(coloured(window, rng, 1500)))
    inner = white[:, 5:]
    power = 2.0 * np.mean(np.abs(inner) ** 2, axis=0) / 2.0
    np.testing.assert_allclose(power.mean(axis=0), 1.0, atol=0.01)
    cross = np.mean(inner[..., 0] * inner[..., 1].conj(), axis=0)
    assert np.abs(cross.mean()) < 0.01


@pytest.mark.parametrize("size", [0.1, 1.0, 30.0])
def test_a_direction_of_prior_size_s_is_left_out_but_for_one_over_root_one_plus_s2(
    size: float,
) -> None:
    window, rng = window_of(), np.random.default_rng(2)
    plain = Whitener(window, correlated(window))
    direction = [column[0] for column in coloured(window, rng, 1)]
    length = float(np.linalg.norm(plain.whiten(direction)))
    scaled = [size / length * column for column in direction]
    left = plain.without([scaled]).whiten(scaled)
    # Marginal likelihood of a prior N(0, 1) of its amplitude: chi2 of it is s^2 / (1 + s^2).
    assert np.sum(left**2) == pytest.approx(size**2 / (1.0 + size**2), rel=1e-9)


def test_what_is_orthogonal_to_nuisances_stays() -> None:
    window, rng = window_of(), np.random.default_rng(3)
    plain = Whitener(window, correlated(window))
    nuisance, other = ([c[i] for c in coloured(window, rng, 2)] for i in range(2))
    u = plain.whiten(nuisance)
    share = plain.whiten(other) @ u / (u @ u)
    orthogonal = [o - share * n for o, n in zip(other, nuisance, strict=True)]
    np.testing.assert_allclose(
        plain.without([nuisance]).whiten(orthogonal), plain.whiten(orthogonal), atol=1e-9
    )


def test_a_slower_signal_is_scored_below_its_own_nyquist_frequency_alone() -> None:
    window, rng, count = window_of(every=4), np.random.default_rng(4), 300
    top = window.frequencies[window.seen[:, 1]].max()
    assert top == pytest.approx(0.45 * 250.0, abs=0.5)
    assert window.frequencies[window.seen[:, 0]].max() == pytest.approx(200.0, abs=0.5)
    whitener = Whitener(window, white_covariance(window, [1.0, 9.0]))
    columns = [rng.standard_normal((count, 2000)), 3.0 * rng.standard_normal((count, 500))]
    chi2 = np.sum(whitener.whiten(columns) ** 2, axis=1) / whitener.n_residuals
    assert abs(chi2.mean() - 1.0) < 4.0 * chi2.std() / np.sqrt(count) < 0.02


def test_spectra_of_both_rates_show_a_slow_tone_alike() -> None:
    window = window_of(every=4)
    fast, slow = np.arange(2000) * STEP, np.arange(500) * 4.0 * STEP
    spectra = window.spectra([np.sin(40.0 * np.pi * fast), np.sin(40.0 * np.pi * slow)])
    at_tone = int(np.argmin(np.abs(window.frequencies - 20.0)))
    # Taper and sampling differ by a row: not more than a hundredth.
    np.testing.assert_allclose(spectra[at_tone, 1], spectra[at_tone, 0], rtol=0.02)


def fitted_with(residual: NDArray[np.float64]) -> Fitted:
    setting = Setting((), TYPICAL)
    empty = np.zeros((0, residual.size))
    return Fitted(Hypothesis(setting), np.zeros(0), [], (residual,), (empty,), [])


@pytest.mark.parametrize("own", [0.02, 0.1, 0.5])
def test_noise_of_its_own_is_measured_beside_what_the_loop_makes_of_the_reading(own: float) -> None:
    """The command follows the reading's noise by 2 and -1.9; what it has beside it is 2 to 50 %."""
    rng = np.random.default_rng(8)

    def through(reading: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.convolve(reading, [2.0, -1.9])[: reading.size]

    found = []
    for _ in range(12):
        reading = rng.standard_normal(3000)
        command = through(reading) + own * rng.standard_normal(3000)
        runs = [(through(r), r) for r in rng.standard_normal((4, 3000))]
        found.append(np.sqrt(power_beside(command, reading, runs)))
    # 540 bins, of which the median is taken, spread it by 5 %; the gain is smoothed over a tenth.
    np.testing.assert_allclose(found, own, rtol=0.25, atol=0.02)
