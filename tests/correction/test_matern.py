"""The Matern covariance against GPyTorch's, and its limits."""

from __future__ import annotations

import gpytorch
import numpy as np
import pytest
import torch

from gmfbo.correction.matern import matern52


@pytest.mark.parametrize("lengthscale", [0.1, 0.4, 1.6])
def test_is_the_covariance_of_gpytorch(lengthscale: float) -> None:
    rng = np.random.default_rng(0)
    one, other = rng.random((7, 3)), rng.random((5, 3))
    kernel = gpytorch.kernels.MaternKernel(nu=2.5).double()
    kernel.lengthscale = torch.tensor(lengthscale, dtype=torch.float64)
    with torch.no_grad():
        theirs = kernel(torch.from_numpy(one), torch.from_numpy(other)).to_dense().numpy()
    np.testing.assert_allclose(matern52(one, other, lengthscale), theirs, rtol=1e-9)


def test_is_one_at_no_distance_and_vanishes_far_away() -> None:
    points = np.array([[0.2, 0.3], [0.9, 0.9]])
    covariance = matern52(points, points, 1e-3)
    np.testing.assert_allclose(covariance, np.eye(2), atol=1e-12)
