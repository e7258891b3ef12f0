"""Held-out stretches speak against names by log density, by two standard errors."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.diagnosis.validating.validation import contradicts_names

FAR = 1e3
GAINS = st.lists(st.floats(-50.0, 50.0), min_size=2, max_size=40)


@given(GAINS)
def test_models_that_foretell_the_same_contradict_nothing(gains: list[float]) -> None:
    assert not contradicts_names(np.array(gains), 0.0)


@given(GAINS)
def test_a_gain_over_all_stretches_contradicts_nothing(gains: list[float]) -> None:
    risen = np.array(gains) - min(0.0, float(np.mean(gains)))
    assert not contradicts_names(risen, FAR)


@pytest.mark.parametrize("count", [4, 16, 64])
def test_the_same_loss_in_each_stretch_contradicts(count: int) -> None:
    assert contradicts_names(np.full(count, -0.5), FAR)


def test_noise_about_zero_contradicts_about_once_in_44_times() -> None:
    """The lower tail beyond two standard errors of a normal mean is 2.3 %; 4,000 draws."""
    rng = np.random.default_rng(0)
    found = [contradicts_names(rng.standard_normal(100), FAR) for _ in range(4000)]
    assert 0.015 < np.mean(found) < 0.033
