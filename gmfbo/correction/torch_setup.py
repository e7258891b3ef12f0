"""Set up torch: one thread, float64, exact linear algebra.

Importing BoTorch changes GPyTorch's global settings, so a model's results would depend on the order
of imports. `exact_algebra` sets them explicitly; all fits and predictions of this project run
inside it.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

import torch

with warnings.catch_warnings():
    # linear_operator 0.6 decorates with torch.jit.script, which torch 2.9 and later deprecate.
    warnings.filterwarnings("ignore", message=".*torch.jit.script", category=DeprecationWarning)
    import botorch  # noqa: F401 - so that all its changes of settings happen here
    import gpytorch
    from linear_operator import settings as linear_operator_settings

# Two threads beside two busy processes make the same code 9 to 43 times slower, and the path of an
# optimiser depends on the thread count.
torch.set_num_threads(1)

DTYPE = torch.float64


@contextmanager
def exact_algebra() -> Iterator[None]:
    """Factorise by Cholesky without approximation, for all sizes that occur here (up to 4096)."""
    with ExitStack() as settings:
        for setting in (
            gpytorch.settings.fast_computations(
                covar_root_decomposition=False, log_prob=False, solves=False
            ),
            gpytorch.settings.max_cholesky_size(4096),
            gpytorch.settings.max_eager_kernel_size(4096),
            gpytorch.settings.cholesky_max_tries(6),
            linear_operator_settings.cholesky_jitter(double_value=1e-8),
        ):
            settings.enter_context(setting)
        yield
