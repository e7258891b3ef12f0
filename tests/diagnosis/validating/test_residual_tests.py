"""What is left of a signal, against the reference: what follows it is seen, noise is not."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import lfilter

from gmfbo.diagnosis.validating.reference_tests import (
    chance_bound,
    following_part,
    reference_columns,
)

Array = NDArray[np.float64]

TIME = 1e-3 * np.arange(2500, dtype=np.float64)
SINE: Array = 0.4 * np.sin(2.0 * np.pi * 1.4 * TIME)


def coloured(rng: np.random.Generator) -> Array:
    """Noise with a time constant of 5 ms and a variance of one."""
    pole = np.exp(-0.2)
    noise = lfilter([np.sqrt(1.0 - pole**2)], [1.0, -pole], rng.standard_normal(TIME.size + 500))
    return np.asarray(noise[500:])


def test_the_part_that_follows_has_its_own_size() -> None:
    columns = reference_columns(TIME, SINE)
    noise = 1e-3 * np.random.default_rng(0).standard_normal(TIME.size)
    friction = 0.2 * np.sign(np.cos(2.0 * np.pi * 1.4 * TIME))
    follows, rest = following_part(columns, friction + noise)
    assert follows == pytest.approx(0.2, rel=0.02)
    assert np.std(rest) < 0.02
    assert follows > 10.0 * chance_bound(columns, rest)


def test_a_delayed_reference_is_followed_too() -> None:
    late = 0.4 * np.sin(2.0 * np.pi * 1.4 * (TIME - 0.13))
    follows, rest = following_part(reference_columns(TIME, SINE), late)
    assert follows == pytest.approx(np.std(late), rel=1e-3)
    assert np.std(rest) < 0.02 * follows


def test_a_constant_follows_nothing() -> None:
    follows, _ = following_part(reference_columns(TIME, SINE), np.full(TIME.size, 3.0))
    assert follows < 1e-12


@pytest.mark.parametrize("kind", ["white", "coloured"])
def test_noise_passes_the_bound_about_once_in_a_hundred_times(kind: str) -> None:
    """Of 400 draws 4 are expected; more than 16 have a probability below 1e-5 at 1 %.

    The covariance is estimated from each draw, which is why 4 % are allowed and not fewer.
    """
    rng = np.random.default_rng(1)
    columns = reference_columns(TIME, SINE)
    above = 0
    for _ in range(400):
        noise = coloured(rng) if kind == "coloured" else rng.standard_normal(TIME.size)
        follows, rest = following_part(columns, noise)
        above += follows > chance_bound(columns, rest)
    assert above <= 16


def test_a_bound_for_white_noise_does_not_serve_coloured_noise() -> None:
    """Negative control: noise of the same variance that is slow asks for a higher bound."""
    rng = np.random.default_rng(2)
    columns = reference_columns(TIME, SINE)
    white = chance_bound(columns, rng.standard_normal(TIME.size))
    assert chance_bound(columns, coloured(rng)) > 2.0 * white


def test_nothing_left_has_no_bound() -> None:
    assert chance_bound(reference_columns(TIME, SINE), np.zeros(TIME.size)) == 0.0
