"""Fit hyperparameters by maximum a posteriori, from fixed starts, with a fallback."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from typing import Any

import torch
from botorch.exceptions.warnings import OptimizationWarning
from botorch.models.gpytorch import GPyTorchModel
from botorch.optim.fit import fit_gpytorch_mll_scipy
from gpytorch.mlls import ExactMarginalLogLikelihood
from linear_operator.utils.cholesky import psd_safe_cholesky
from linear_operator.utils.errors import NanError, NotPSDError
from linear_operator.utils.warnings import NumericalWarning
from torch import Tensor

from gmfbo.correction.torch_setup import exact_algebra

# Factors on the initial noise variance. The posterior has two modes, "smooth and noisy" and
# "rough and exact"; the initial noise, and not the lengthscales, decides in which one a descent
# ends. The starts are fixed, not drawn from the priors, so that the same data gives the same
# model whatever else used torch's generator.
STARTS = (1.0, 100.0)
# `ftol` is of the log posterior per observation: 1e-6 of it is too little to change a decision.
OPTIONS = {"maxiter": 100, "ftol": 1e-6}


def fit_by_map(model: GPyTorchModel, starts: Sequence[float] = STARTS) -> str:
    """Fit by L-BFGS-B from several starting points and keep the best.

    Parameters
    ----------
    model : GPyTorchModel
        Fitted in place, left in evaluation mode.
    starts : sequence of float
        Factors on the noise variance that the model came with.

    Returns
    -------
    str
        Empty, or one line that says what went wrong and what was done instead.
    """
    likelihood = ExactMarginalLogLikelihood(model.likelihood, model)
    initial = _copy(model)
    candidates = [_scaled(initial, factor) for factor in starts]
    best_loss, best = float("inf"), initial
    problems = []
    for start in candidates:
        _restore(model, start)
        try:
            loss = _descend(likelihood)
        except (NotPSDError, NanError) as error:
            problems.append(type(error).__name__)
            continue
        if loss < best_loss:
            best_loss, best = loss, _copy(model)
    _restore(model, best)
    likelihood.eval()
    if best_loss == float("inf"):
        return (
            f"no fit converged ({', '.join(problems)}); kept the starting hyperparameters, "
            "so predictions rest on the priors"
        )
    if problems:
        return f"{len(problems)} of {len(candidates)} fits failed ({', '.join(problems)})"
    return ""


def _descend(likelihood: ExactMarginalLogLikelihood) -> float:
    """Run one L-BFGS-B descent; returns the negative log posterior reached."""
    likelihood.train()
    with exact_algebra(), warnings.catch_warnings():
        # A descent that reaches the limit of iterations is compared with the other starts by its
        # likelihood; a first Cholesky that needs jitter is repeated by linear_operator.
        warnings.simplefilter("ignore", OptimizationWarning)
        warnings.simplefilter("ignore", NumericalWarning)
        result = fit_gpytorch_mll_scipy(
            likelihood, closure=_loss_and_gradient(likelihood.model), options=OPTIONS
        )
    value = float(result.fval)
    if value != value:
        raise NanError("the log likelihood is not a number")
    return value


def _loss_and_gradient(
    model: Any,
) -> Callable[[], tuple[Tensor, tuple[Tensor | None, ...]]]:
    """Negative log posterior per observation, and its gradient by the free parameters.

    The value of GPyTorch's `ExactMarginalLogLikelihood`, on plain tensors: of these small
    matrices its lazy operators cost more than the algebra.
    """
    inputs, targets = model.train_inputs[0], model.train_targets
    free = [parameter for parameter in model.parameters() if parameter.requires_grad]
    constant = 0.5 * len(targets) * math.log(2.0 * math.pi)

    def closure() -> tuple[Tensor, tuple[Tensor | None, ...]]:
        noise = model.likelihood.noise_covar(inputs, shape=targets.shape).diagonal()
        covariance = model.covar_module.forward(inputs, inputs) + torch.diag(noise)
        factor = psd_safe_cholesky(covariance)
        residual = (targets - model.mean_module(inputs))[:, None]
        white = torch.linalg.solve_triangular(factor, residual, upper=False)
        posterior = -0.5 * white.square().sum() - factor.diagonal().log().sum() - constant
        for _, module, prior, value_of, _ in model.named_priors():
            posterior = posterior + prior.log_prob(value_of(module)).sum()
        loss = -posterior / len(targets)
        gradient = torch.autograd.grad(loss, free, allow_unused=True)
        return loss.detach(), gradient

    return closure


def _copy(model: GPyTorchModel) -> dict[str, Tensor]:
    return {name: value.detach().clone() for name, value in model.named_parameters()}


def _restore(model: GPyTorchModel, values: dict[str, Tensor]) -> None:
    with torch.no_grad():
        for name, parameter in model.named_parameters():
            parameter.copy_(values[name])


def _scaled(values: dict[str, Tensor], factor: float) -> dict[str, Tensor]:
    # The raw noise variance is a logarithm.
    return {
        name: value + math.log(factor) if name.endswith("raw_noise") else value
        for name, value in values.items()
    }
