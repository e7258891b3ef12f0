"""Frequency responses of kernels, against the sum that defines them."""

from __future__ import annotations

import numpy as np
import pytest

from gmfbo.diagnosis.comparison.port_kernels import PortKernels

STEP = 2e-3


@pytest.mark.parametrize(
    "frequencies",
    [
        np.arange(251) / (500 * STEP),
        np.arange(60) / (1500 * STEP),
        np.arange(101) / (200 * STEP),
        np.arange(251) / (500 * STEP * (1.0 + 4e-6)),
        np.linspace(3.0, 40.0, 23),
    ],
    ids=["own rows", "rows three times as far apart", "fewer than taps", "another clock", "others"],
)
def test_a_response_is_the_fourier_sum_of_its_taps(frequencies: np.ndarray) -> None:
    taps = np.random.default_rng(1).standard_normal((2, 300))
    kernels = PortKernels({"torque": {"position": taps[0], "command": taps[1]}}, STEP)
    found = kernels.spectra("torque", ("position", "command"), frequencies)
    turn = np.exp(-2j * np.pi * np.outer(np.arange(300) * STEP, frequencies))
    np.testing.assert_allclose(found, taps @ turn, atol=1e-9)
