r"""BoTorch's multi-fidelity surrogate with its linear truncated kernel.

c(z, z') = sigma^2 (c_0(k, k') + (1 - s)(1 - s')(1 + s s')^p c_1(k, k')),  z = [k, s], s in {0, 1}

One output scale serves both parts, so that the correlation of axis and twin at equal gains is
always sqrt(1/2) = 0.707. With s in {0, 1}, c = 2 sigma^2 for two runs of the twin, and sigma^2
for every other pair. (Poloczek, Wang and Frazier 2017; kernel and priors of BoTorch.)
"""

from __future__ import annotations

import numpy as np
import torch
from botorch.fit import fit_gpytorch_mll
from botorch.models.gp_regression_fidelity import SingleTaskMultiFidelityGP
from botorch.utils.sampling import manual_seed
from gpytorch.mlls import ExactMarginalLogLikelihood
from numpy.typing import ArrayLike, NDArray

from gmfbo.correction.torch_setup import exact_algebra
from gmfbo.surrogate.extra_noise import believe_less
from gmfbo.surrogate.observations import Observations, with_source


class TruncatedModel(SingleTaskMultiFidelityGP):
    """`SingleTaskMultiFidelityGP` of g over [gains, source], as BoTorch's tutorial uses it.

    `note`, which every surrogate has, is always empty.
    """

    note = ""

    @classmethod
    def fit(cls, observations: Observations) -> TruncatedModel:
        """Fit runs of axis and twin by maximum a posteriori; the same data gives the same model."""
        inputs = observations.train_X()
        model = cls(inputs, observations.train_Y(), data_fidelities=[inputs.shape[-1] - 1])
        believe_less(model, observations)
        # A fit that fails is tried again from draws of the priors.
        with exact_algebra(), manual_seed(0):
            fit_gpytorch_mll(ExactMarginalLogLikelihood(model.likelihood, model))
        return model

    def predict(
        self, points: ArrayLike, source: str
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Posterior of the noise-free objective.

        Parameters
        ----------
        points : array_like, shape (m, d)
            Gains in the unit cube.
        source : str
            `IS1` or `IS2`.

        Returns
        -------
        mean : ndarray, shape (m,)
            [g]
        variance : ndarray, shape (m,)
            [g^2]
        """
        with exact_algebra(), torch.no_grad():
            posterior = self.posterior(with_source(points, source))
            return posterior.mean[:, 0].numpy(), posterior.variance[:, 0].numpy()
