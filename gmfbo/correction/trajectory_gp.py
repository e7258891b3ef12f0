"""Gaussian process that corrects a twin's trajectory by real runs.

Inputs (t, y_twin(t)), and the gains in the unit cube where several runs are kept; time, signal and
target are standardised; Matern-5/2 with one lengthscale an input::

    pair = Pair(time (n,), simulated (n,), measured (n,), gains (d,))   # both ran at these gains
    correction = TrajectoryCorrection.fit([pair])                # as published: the last run only
    correction = TrajectoryCorrection.fit(pairs, CorrectionSettings(memory="accumulate"))
    mean, std = correction.correct(time (m,), simulated (m,), gains (d,))   # [signal], [signal]
    correction.held_out_error     # [signal] RMS error, each sample predicted from the others
    correction.uncorrected_error  # [signal] RMS error of the twin over the same samples
    correction.note               # "" or what went wrong in the fit

As published (`latest`) the target is the measured signal, and only the last run counts. With
several runs, one input (t, y_twin) could have several targets, so `accumulate` adds the gains to
the inputs and models the error of the twin, measured - simulated.

The hyperparameters are fitted to at most `max_points` samples, denser where the response or its
error changes, since a fit to 1101 samples takes several seconds. The posterior then uses all
samples of the run, which costs one factorisation.
`CorrectionSettings(exact=True)` fits the hyperparameters to all samples too, as the reference.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import torch
from botorch.models import SingleTaskGP
from botorch.utils.constraints import LogTransformedInterval
from gpytorch.kernels import MaternKernel, ScaleKernel
from gpytorch.likelihoods import GaussianLikelihood
from gpytorch.priors import LogNormalPrior
from numpy.typing import ArrayLike, NDArray
from torch import Tensor

from gmfbo.correction.fitting import fit_by_map
from gmfbo.correction.thinning import thin
from gmfbo.correction.torch_setup import DTYPE, exact_algebra
from gmfbo.errors import InputError

Memory = Literal["latest", "accumulate"]


@dataclass(frozen=True, eq=False)
class Pair:
    """One run of the axis and the twin's run at the same gains, on the same times.

    Attributes
    ----------
    time : ndarray, shape (n,)
        [s]
    simulated, measured : ndarray, shape (n,)
        The signal from twin and axis, same unit; NaN in `measured` where it was not sampled.
    gains : ndarray, shape (d,), optional
        In the unit cube.
    """

    time: NDArray[np.float64]
    simulated: NDArray[np.float64]
    measured: NDArray[np.float64]
    gains: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        columns = [np.asarray(c, dtype=float) for c in (self.time, self.simulated, self.measured)]
        if columns[0].ndim != 1 or len({column.shape for column in columns}) != 1:
            raise InputError(
                "expected time, simulated and measured of one length, got shapes "
                + ", ".join(str(column.shape) for column in columns)
            )
        sampled = np.isfinite(columns[2])
        if not np.all(np.isfinite(columns[1][sampled])) or sampled.sum() < 2:
            raise InputError(
                "a correction needs at least two measured samples and a finite simulation; "
                "leave out runs that failed"
            )
        for name, column in zip(("time", "simulated", "measured"), columns, strict=True):
            object.__setattr__(self, name, column[sampled])
        if self.gains is not None:
            object.__setattr__(self, "gains", np.asarray(self.gains, dtype=float))


@dataclass(frozen=True)
class CorrectionSettings:
    """Settings of the correction.

    Attributes
    ----------
    memory : {"latest", "accumulate"}
        The last run only, target y_axis (as published), or all runs with the gains as inputs,
        target y_axis - y_twin.
    max_points : int
        Most samples that the hyperparameters are fitted to.
    points_per_run : int
        Most samples that the posterior keeps of each run where there are several.
    noise_floor : float
        Least noise variance of the standardised target.
    exact : bool
        Use every sample of every run.
    """

    memory: Memory = "latest"
    max_points: int = 300
    points_per_run: int = 100
    noise_floor: float = 1e-6
    exact: bool = False


class TrajectoryCorrection:
    """Posterior over the measured signal, given the twin's; made by `fit`.

    Attributes
    ----------
    settings : CorrectionSettings
        Settings of the fit.
    held_out_error : float
        [signal] RMS error of predicting each sample from all others.
    uncorrected_error : float
        [signal] RMS error of the twin over the same samples.
    note : str
        Empty, or what went wrong in the fit and what was done.
    """

    def __init__(
        self, inputs: Tensor, targets: Tensor, settings: CorrectionSettings, hyper_rows: Tensor
    ) -> None:
        self.settings = settings
        self._input_shift, self._input_scale = _standardisation(inputs)
        # Gains are in the unit cube, and a few runs do not tell their spread.
        self._input_shift[2:], self._input_scale[2:] = 0.0, 1.0
        self._target_shift, self._target_scale = _standardisation(targets)
        scaled = (inputs - self._input_shift) / self._input_scale
        values = (targets - self._target_shift) / self._target_scale
        self._process = _process(scaled[hyper_rows], values[hyper_rows], settings.noise_floor)
        self.note = fit_by_map(self._process, starts=(1.0,))
        self.held_out_error = self.uncorrected_error = float("nan")
        self._condition(scaled, values)

    @classmethod
    def fit(
        cls, pairs: Sequence[Pair], settings: CorrectionSettings | None = None
    ) -> TrajectoryCorrection:
        """Fit to runs of axis and twin at the same gains; the same data gives the same fit.

        Parameters
        ----------
        pairs : sequence of Pair
            In the order in which they were run; `latest` uses the last one.
        settings : CorrectionSettings, optional
            Settings of the correction.

        Raises
        ------
        InputError
            There is no pair, or `accumulate` has a pair without gains.
        """
        settings = settings or CorrectionSettings()
        if len(pairs) == 0:
            raise InputError("a correction needs at least one run of the axis and of the twin")
        used = list(pairs) if settings.memory == "accumulate" else [pairs[-1]]
        kept = [_kept(pair, settings, len(used)) for pair in used]
        inputs = torch.cat(
            [
                _inputs(p.time, p.simulated, p.gains, settings)[i]
                for p, i in zip(used, kept, strict=True)
            ]
        )
        targets = np.concatenate([_target(p, settings)[i] for p, i in zip(used, kept, strict=True)])
        correction = cls(
            inputs,
            torch.tensor(targets, dtype=DTYPE)[:, None],
            settings,
            torch.from_numpy(_hyper_rows(used, kept, settings)),
        )
        errors = [(p.measured - p.simulated)[i] for p, i in zip(used, kept, strict=True)]
        correction.uncorrected_error = _rms(np.concatenate(errors))
        return correction

    def correct(
        self, time: ArrayLike, simulated: ArrayLike, gains: ArrayLike | None = None
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Predict the measured signal of the axis.

        Parameters
        ----------
        time : array_like, shape (n,)
            [s]
        simulated : array_like, shape (n,)
            The twin's signal at these times.
        gains : array_like, shape (d,), optional
            In the unit cube, of the simulated run; needed with `accumulate`.

        Returns
        -------
        mean, std : ndarray, shape (n,)
            [signal] Posterior of the noise-free signal.

        Raises
        ------
        InputError
            `accumulate` got no gains.
        """
        twin = np.asarray(simulated, dtype=float)
        point = None if gains is None else np.asarray(gains, dtype=float)
        inputs = _inputs(np.asarray(time, dtype=float), twin, point, self.settings)
        with exact_algebra(), torch.no_grad():
            scaled = (inputs - self._input_shift) / self._input_scale
            kernel = self._process.covar_module
            half = torch.linalg.solve_triangular(
                self._factor, kernel.forward(self._inputs, scaled), upper=False
            )
            variance = kernel.forward(scaled, scaled, diag=True) - half.square().sum(dim=0)
            mean = self._process.mean_module(scaled) + (half.T @ self._white)[:, 0]
            mean = self._target_shift + self._target_scale * mean
            std = self._target_scale * variance.clamp_min(0.0).sqrt()
        offset = twin if self.settings.memory == "accumulate" else 0.0
        return offset + mean.numpy(), std.numpy()

    def _condition(self, inputs: Tensor, values: Tensor) -> None:
        process = self._process
        with exact_algebra(), torch.no_grad():
            covariance = process.covar_module.forward(inputs, inputs)
            covariance.diagonal().add_(process.likelihood.noise)
            self._inputs = inputs
            self._factor = torch.linalg.cholesky(covariance)
            residual = values - process.mean_module(inputs)[:, None]
            self._white = torch.linalg.solve_triangular(self._factor, residual, upper=False)
            # Leaving one out in closed form: Rasmussen and Williams (2006), equation 5.12.
            inverse = torch.cholesky_inverse(self._factor)
            left_out = (inverse @ residual)[:, 0] / inverse.diagonal()
            self.held_out_error = _rms((left_out * self._target_scale).numpy())


def _kept(pair: Pair, settings: CorrectionSettings, runs: int) -> NDArray[np.intp]:
    if runs == 1 or settings.exact:
        return np.arange(len(pair.time))
    return thin(pair.time, pair.simulated, pair.measured, settings.points_per_run)


def _hyper_rows(
    pairs: Sequence[Pair], kept: Sequence[NDArray[np.intp]], settings: CorrectionSettings
) -> NDArray[np.intp]:
    """Rows, among all kept ones, to which the hyperparameters are fitted."""
    rows, before = [], 0
    share = max(2, settings.max_points // len(pairs))
    for pair, index in zip(pairs, kept, strict=True):
        columns = (pair.time[index], pair.simulated[index], pair.measured[index])
        chosen = np.arange(len(index)) if settings.exact else thin(*columns, share)
        rows.append(before + chosen)
        before += len(index)
    return np.concatenate(rows)


def _inputs(
    time: NDArray[np.float64],
    simulated: NDArray[np.float64],
    gains: NDArray[np.float64] | None,
    settings: CorrectionSettings,
) -> Tensor:
    columns = [time, simulated]
    if settings.memory == "accumulate":
        if gains is None:
            raise InputError("memory 'accumulate' needs the gains of each run; give them in [0, 1]")
        columns += [np.full(len(time), gain) for gain in gains]
    return torch.tensor(np.stack(columns, axis=-1), dtype=DTYPE)


def _target(pair: Pair, settings: CorrectionSettings) -> NDArray[np.float64]:
    if settings.memory == "accumulate":
        return pair.measured - pair.simulated
    return pair.measured


def _standardisation(columns: Tensor) -> tuple[Tensor, Tensor]:
    scale = columns.std(dim=0)
    # A constant column carries no information and is left unscaled.
    return columns.mean(dim=0), torch.where(scale > 1e-12, scale, torch.ones_like(scale))


def _process(inputs: Tensor, values: Tensor, noise_floor: float) -> SingleTaskGP:
    width = inputs.shape[-1]
    kernel = ScaleKernel(
        MaternKernel(
            nu=2.5,
            ard_num_dims=width,
            # Weak for time and signal. For the gains most of the unit cube within a factor of four:
            # a single run cannot determine their lengthscale.
            lengthscale_prior=LogNormalPrior(
                torch.zeros(width, dtype=DTYPE),
                torch.tensor([1.5, 1.5] + [0.7] * (width - 2), dtype=DTYPE),
            ),
            lengthscale_constraint=LogTransformedInterval(1e-3, 1e3, initial_value=0.5),
        ),
        outputscale_prior=LogNormalPrior(0.0, 1.5),
        outputscale_constraint=LogTransformedInterval(1e-4, 1e4, initial_value=1.0),
    )
    likelihood = GaussianLikelihood(
        noise_prior=LogNormalPrior(-8.0, 3.0),
        noise_constraint=LogTransformedInterval(noise_floor, 1.0, initial_value=1e-3),
    )
    return SingleTaskGP(
        inputs, values, covar_module=kernel, likelihood=likelihood, outcome_transform=None
    )


def _rms(values: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(values**2)))
