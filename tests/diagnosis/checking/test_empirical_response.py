"""The response from the reference is that of the system, with a bound where noise ends it."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import dfreqresp, dlsim, freqz, lfilter

from gmfbo.diagnosis.checking.empirical_response import Response, empirical_response

STEP = 1e-3
B, A = [0.02, 0.01], [1.0, -1.6, 0.65]
System = tuple[list[float], list[float], float]


def reference(seed: int, rows: int = 6000) -> NDArray[np.float64]:
    return np.asarray(np.random.default_rng(seed).standard_normal(rows))


def mean_error(response: Response, system: System) -> float:
    """Of the estimate from 20 to 200 Hz, where scatter averages out."""
    chosen = (response.frequency > 20.0) & (response.frequency < 200.0)
    _, exact = dfreqresp(system, 2.0 * np.pi * response.frequency[chosen] * STEP)
    return float(abs(np.mean(response.value[chosen] / exact) - 1.0))


def test_a_known_filter_is_found_at_every_frequency() -> None:
    sources = [reference(seed) for seed in range(8)]
    response = empirical_response(sources, [lfilter(B, A, x) for x in sources], STEP)
    assert response is not None
    _, exact = freqz(B, A, worN=response.frequency, fs=1.0 / STEP)
    inner = slice(2, -2)
    error = np.abs(response.value[inner] / exact[inner] - 1.0)
    assert error.max() < 0.05
    assert response.trusted[1] > 0.45 / STEP


def test_noise_in_the_loop_does_not_bias_the_response_from_the_reference() -> None:
    """Plant z^-1 b / (1 - a z^-1) under u = k (r - y - n): from u to y the estimate is biased."""
    a, b, k = 0.9, 0.1, 4.0
    rng = np.random.default_rng(3)
    sources, commands, outputs = [], [], []
    for _ in range(12):
        r, n = rng.standard_normal((2, 6000))
        loop = ([k * b], [1.0, k * b - a], 1.0)
        y = dlsim(loop, r - 2.0 * n)[1][:, 0]
        sources.append(r)
        outputs.append(y + 2.0 * n)
        commands.append(k * (r - y - 2.0 * n))
    through = empirical_response(sources, outputs, STEP)
    direct = empirical_response(commands, outputs, STEP)
    assert through is not None
    assert direct is not None
    closed: System = ([k * b], [1.0, k * b - a], 1.0)
    plant: System = ([b], [1.0, -a], 1.0)
    unbiased, biased = mean_error(through, closed), mean_error(direct, plant)
    assert unbiased < 0.1
    assert biased > 0.5


def test_the_stated_error_is_that_of_repeated_estimates() -> None:
    rng = np.random.default_rng(0)
    found, stated = [], []
    for _ in range(60):
        x = rng.standard_normal(3000)
        y = lfilter(B, A, x) + 0.05 * rng.standard_normal(3000)
        response = empirical_response([x], [y], STEP)
        assert response is not None
        found.append(np.abs(response.value[5:60]))
        stated.append(response.error[5:60])
    spread = np.std(found, axis=0) / np.mean(found, axis=0)
    assert 0.5 < float(np.median(spread / np.median(stated, axis=0))) < 2.0


def test_it_is_trusted_up_to_where_noise_drowns_the_signal() -> None:
    rng = np.random.default_rng(1)
    slow = [lfilter([0.06], [1.0, -0.94], reference(seed)) for seed in range(8)]
    noisy = [x + 0.02 * rng.standard_normal(x.size) for x in slow]
    louder = [x + 0.2 * rng.standard_normal(x.size) for x in slow]
    quiet, loud = (empirical_response(slow, ys, STEP) for ys in (noisy, louder))
    assert quiet is not None
    assert loud is not None
    # First-order low pass: 10 times the noise is reached at a tenth of the frequency.
    assert quiet.trusted[1] / loud.trusted[1] == pytest.approx(10.0, rel=0.5)


def test_nothing_is_said_where_nothing_moves_or_too_little_was_recorded() -> None:
    assert empirical_response([np.zeros(3000)], [reference(0, 3000)], STEP) is None
    assert empirical_response([reference(0, 60)], [reference(1, 60)], STEP) is None


def test_unrelated_signals_are_not_trusted_over_any_band() -> None:
    sources = [reference(seed) for seed in range(8)]
    response = empirical_response(sources, [reference(seed + 100) for seed in range(8)], STEP)
    assert response is not None
    assert all(np.isnan(end) for end in response.trusted)


def test_nothing_is_told_above_half_the_sampling_rate() -> None:
    """A signal that was logged at a tenth of the rate, with what interpolation makes of it."""
    source = reference(4)
    rows = np.arange(source.size)
    slow = np.interp(rows, rows[::10], lfilter(B, A, source)[::10])
    half = 0.5 / (10.0 * STEP)
    response = empirical_response([source], [slow], STEP, half)
    assert response is not None
    assert response.frequency.max() <= half
    # Negative control: unlimited, it goes on up to half the rate of the rows.
    unlimited = empirical_response([source], [slow], STEP)
    assert unlimited is not None
    assert unlimited.frequency.max() > 9.0 * half


@pytest.mark.parametrize("quantum", [0.0, 1e-6, 1e-4], ids=["exact", "fine", "coarse"])
def test_a_single_tone_is_trusted_at_its_own_frequency_alone(quantum: float) -> None:
    """Elsewhere its column holds its leakage and its rounding, which drive nothing."""
    time = np.arange(2500) * STEP
    tones = [np.sin(2.0 * np.pi * f * time) for f in (3.1, 5.7)]
    read = [np.round(x / quantum) * quantum if quantum else x for x in tones]
    response = empirical_response(read, [lfilter(B, A, x) for x in tones], STEP)
    assert response is not None
    bin_width = 1.0 / (2500 / 3 * STEP)
    low, high = response.trusted
    assert low == pytest.approx(3.1, abs=2.0 * bin_width)
    assert high == pytest.approx(5.7, abs=2.0 * bin_width)


def test_a_slow_tone_in_coarse_steps_is_not_trusted_beyond_itself() -> None:
    """Rounding of both columns to a thousandth: their steps are alike, and drive nothing."""
    rng = np.random.default_rng(0)
    time = np.arange(2500) * STEP
    for _ in range(40):
        f, phase = rng.uniform(1.3, 2.5), rng.uniform(0.0, 2.0 * np.pi)
        x = np.sin(2.0 * np.pi * f * time + phase)
        read = [np.asarray(np.round(own, 3), float) for own in (x, lfilter(B, A, x))]
        response = empirical_response(read[:1], read[1:], STEP)
        assert response is not None
        assert response.trusted[1] < f + 2.4


def test_weak_tones_far_below_the_strongest_are_trusted_where_they_exceed_leakage() -> None:
    """Negative control: a tone of a ten-thousandth is heard, since its column is exact."""
    time = np.arange(6000) * STEP
    x = np.sin(2.0 * np.pi * 2.0 * time) + 1e-4 * np.sin(2.0 * np.pi * 90.0 * time)
    response = empirical_response([x], [lfilter(B, A, x)], STEP)
    assert response is not None
    assert np.min(np.abs(response.frequency - 90.0)) < 1.0
