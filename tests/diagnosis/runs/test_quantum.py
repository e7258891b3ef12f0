"""The quantum of a column is found however it was counted and written."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.diagnosis.runs.quantum import resolution


@given(st.floats(1e-7, 1e3), st.integers(0, 2**32 - 1))
def test_the_quantum_of_a_rounded_signal_is_found(quantum: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    smooth = 40.0 * np.sin(np.linspace(0.0, 12.0, 800)) + rng.standard_normal(800)
    assert resolution(quantum * np.round(smooth)) == pytest.approx(quantum, rel=1e-3)


@given(st.floats(1e-5, 1e-2), st.integers(0, 99))
def test_counts_are_found_where_each_row_passes_many(quantum: float, seed: int) -> None:
    steps = np.random.default_rng(seed).uniform(-90.0, 90.0, 2000)
    assert resolution(quantum * np.floor(steps.cumsum())) == pytest.approx(quantum, rel=1e-6)


def test_a_continuous_signal_has_no_quantum() -> None:
    assert resolution(np.random.default_rng(0).standard_normal(500).cumsum()) == 0.0


def test_a_constant_signal_has_no_quantum() -> None:
    assert resolution(np.full(500, 0.3)) == 0.0


@pytest.mark.parametrize("counts", [4096, 10_000, 32_768])
@pytest.mark.parametrize("fastest", [0.4, 3.0])
def test_counts_that_were_rounded_once_more_are_found(counts: int, fastest: float) -> None:
    """Degrees of an encoder, written with about a twentieth of a count."""
    count = 360.0 / counts
    digits = int(np.ceil(-np.log10(count / 20.0)))
    rng = np.random.default_rng(2)
    speed = fastest * np.sin(np.linspace(0.0, 25.0, 3000))
    true = np.cumsum(speed) + 0.2 * rng.standard_normal(3000)
    written = np.round(np.round(true) * count, digits)
    assert resolution(written) == pytest.approx(count, rel=2e-3)
    # Negative control: the same motion, written alike and not counted.
    grid = resolution(np.round(true * count, digits))
    assert grid == pytest.approx(10.0**-digits, rel=1e-3) or grid == 0.0


def test_steps_of_an_integral_are_no_quantum_of_its_column() -> None:
    """The error is whole counts; their sum times a gain meets no value twice by its grid."""
    rng = np.random.default_rng(3)
    error = np.repeat(rng.integers(-3, 4, 200), 5)
    drift = 1e-3 * np.linspace(0.0, 1.0, 1000) ** 2
    column = np.asarray(5e-3 * np.cumsum(error) + np.cumsum(drift), dtype=np.float64)
    assert resolution(column) == 0.0
