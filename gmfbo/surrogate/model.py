"""Surrogate: a Gaussian process over gains and information source.

`SourceModel` is a BoTorch model of the objective g, which is minimised: its posterior is in
units of g, its inputs are [gains in the unit cube, source column]. `SourceModel.fit` takes
NumPy observations and settings, `predict` gives NumPy back::

    observations = Observations(points (n, d), sources (n names), values (n,))
    model = SourceModel.fit(observations, SurrogateSettings(source_lengthscale=1.0))
    mean, variance = model.predict(points (m, d), "IS1")     # [g], [g^2]
    covariance = model.covariance(points (m, d), "IS1", "IS2")   # of both sources at one point
    model.note            # "" or, in a line, what went wrong in the fit and what was done

`posterior` (BoTorch) and `predict` agree; `predict` takes thousands of points at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from botorch.models import SingleTaskGP
from botorch.models.transforms.outcome import Standardize
from gpytorch.kernels import Kernel
from gpytorch.means import Mean
from numpy.typing import ArrayLike, NDArray
from torch import Tensor

from gmfbo.correction.fitting import fit_by_map
from gmfbo.correction.torch_setup import exact_algebra
from gmfbo.surrogate.extra_noise import believe_less
from gmfbo.surrogate.kernel import AdaptiveSourceKernel
from gmfbo.surrogate.noise import SourceNoiseLikelihood
from gmfbo.surrogate.observations import Observations, with_source


@dataclass(frozen=True)
class SurrogateSettings:
    """Settings of the surrogate; the defaults are the publication's.

    Attributes
    ----------
    source_lengthscale : float or None
        l_g0; None learns it in [0.1, cap].
    cap : float
        Upper bound of a learned l_g0.
    ard : bool
        One lengthscale for each gain.
    third_source : bool
        Whether the corrected twin is a source of its own, not the twin.
    noise_per_source : bool
        One noise variance for each source.
    noise_floor : float
        Least noise variance of the standardised objective.
    """

    source_lengthscale: float | None = 1.0
    cap: float = 5.0
    ard: bool = False
    third_source: bool = False
    noise_per_source: bool = False
    noise_floor: float = 1e-6


class SourceModel(SingleTaskGP):
    """Exact Gaussian process over [gains, source] with `AdaptiveSourceKernel`.

    Parameters
    ----------
    train_X : Tensor, shape (n, d + 1)
        Gains in the unit cube; the last column is the source (1 axis, 0 twin, 0.5 corrected).
    train_Y : Tensor, shape (n, 1)
        Objective g, to be minimised, on its own scale.
    covar_module : Kernel, optional
        Kernel in place of the published one with l_g0 = 1.
    likelihood : SourceNoiseLikelihood, optional
        Likelihood in place of one noise variance for all sources.
    mean_module : Mean, optional
        Mean in place of a constant; in units of the standardised objective.
    """

    def __init__(
        self,
        train_X: Tensor,
        train_Y: Tensor,
        covar_module: Kernel | None = None,
        likelihood: SourceNoiseLikelihood | None = None,
        mean_module: Mean | None = None,
    ) -> None:
        super().__init__(
            train_X=train_X,
            train_Y=train_Y,
            covar_module=covar_module or AdaptiveSourceKernel(train_X.shape[-1] - 1),
            likelihood=likelihood or SourceNoiseLikelihood(),
            mean_module=mean_module,
            outcome_transform=Standardize(m=1),
        )
        self.note = ""

    @classmethod
    def fit(
        cls, observations: Observations, settings: SurrogateSettings | None = None
    ) -> SourceModel:
        """Fit the hyperparameters by maximum a posteriori; the same data gives the same model.

        Each fit starts afresh, so that a resumed study continues exactly.
        """
        settings = settings or SurrogateSettings()
        train_X = observations.train_X()
        model = cls(
            train_X,
            observations.train_Y(),
            covar_module=AdaptiveSourceKernel(
                train_X.shape[-1] - 1,
                source_lengthscale=settings.source_lengthscale,
                cap=settings.cap,
                ard=settings.ard,
                third_source=settings.third_source,
            ),
            likelihood=SourceNoiseLikelihood(
                per_source=settings.noise_per_source, floor=settings.noise_floor
            ),
        )
        believe_less(model, observations)
        model.note = fit_by_map(model)
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
            `IS1`, `IS2` or `IS3`.

        Returns
        -------
        mean : ndarray, shape (m,)
            [g]
        variance : ndarray, shape (m,)
            [g^2]
        """
        with exact_algebra(), torch.no_grad():
            inputs = with_source(points, source)
            mean, half = self._project(inputs)
            prior = self.covar_module.forward(inputs, inputs, diag=True)
            variance = (prior - half.square().sum(dim=0)).clamp_min(0.0)
            shift, scale = self._scale()
            return (shift + scale * mean).numpy(), (scale**2 * variance).numpy()

    def covariance(self, points: ArrayLike, first: str, second: str) -> NDArray[np.float64]:
        """Posterior covariance [g^2] of two sources at the same points, shape (m,)."""
        with exact_algebra(), torch.no_grad():
            one, two = with_source(points, first), with_source(points, second)
            prior = self.covar_module.forward(one, two, diag=True)
            both = prior - (self._project(one)[1] * self._project(two)[1]).sum(dim=0)
            return (self._scale()[1] ** 2 * both).numpy()

    def _scale(self) -> tuple[Tensor, Tensor]:
        transform: Any = self.outcome_transform
        return transform.means.flatten()[0], transform.stdvs.flatten()[0]

    def _project(self, inputs: Tensor) -> tuple[Tensor, Tensor]:
        """Standardised mean at inputs, and L^-1 k(X, inputs) with L L^T = K + noise."""
        train = self.train_inputs[0]
        noise = self.likelihood.noise_covar(train).diagonal()
        covariance = self.covar_module.forward(train, train) + torch.diag(noise)
        factor = torch.linalg.cholesky(covariance)
        half = torch.linalg.solve_triangular(
            factor, self.covar_module.forward(train, inputs), upper=False
        )
        residual = (self.train_targets - self.mean_module(train))[:, None]
        white = torch.linalg.solve_triangular(factor, residual, upper=False)
        return self.mean_module(inputs) + (half.T @ white)[:, 0], half
