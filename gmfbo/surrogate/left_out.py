"""How well runs of the real axis are predicted from the others, with and without the twin."""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray

from gmfbo.correction.torch_setup import exact_algebra
from gmfbo.surrogate.corrected_twin import AxisRuns, CorrectedTwinModel, CostOf
from gmfbo.surrogate.model import SourceModel


def errors_with_twin(runs: AxisRuns, cost_of: CostOf) -> NDArray[np.float64]:
    """Errors of the corrected twin [g], shape (n,); NaN where the axis or the twin failed.

    Each run is predicted by a model that was fitted to the others alone.

    Parameters
    ----------
    runs : AxisRuns
        All real runs.
    cost_of : callable
        From trajectories, shape (q, m), to g, shape (q,).
    """
    errors = np.full(len(runs.values), np.nan)
    for row in np.flatnonzero(runs.paired) if len(runs.values) > 1 else ():
        others = np.arange(len(runs.values)) != row
        model = CorrectedTwinModel.fit(
            AxisRuns(
                runs.points[others],
                runs.values[others],
                runs.simulated[others],
                runs.measured[others],
                runs.extra_of(others),
            ),
            cost_of,
        )
        mean, _ = model.predict(runs.points[[row]], runs.simulated[[row]])
        errors[row] = runs.values[row] - mean[0]
    return errors


def errors_alone(model: SourceModel) -> NDArray[np.float64]:
    """Errors of a Gaussian process on the real runs [g], shape (n,), in closed form.

    y_i - mu_-i = [K^-1 (y - m)]_i / [K^-1]_ii (Rasmussen and Williams 2006, equation 5.12), with
    the hyperparameters that were fitted to all runs; this favours it a little over a refit.

    Parameters
    ----------
    model : SourceModel
        Fitted to runs of the axis alone.
    """
    with exact_algebra(), torch.no_grad():
        train = model.train_inputs[0]
        covariance = model.observed_covariance()
        inverse = torch.linalg.inv(covariance)
        residual = model.train_targets - model.mean_module(train)
        errors = (inverse @ residual) / inverse.diagonal()
        return model.standard_deviation * np.asarray(errors.numpy())
