"""Train a correction from a study with h5py and gpytorch alone: no gmfbo in this process.

Usage: correction_outside_gmfbo.py INDEX_OR_PACKED_FILE

For each run of the real axis (IS1) there is a run of the twin at the same gains (IS2, whose
`parent` it is). A Gaussian process learns (t, y_IS2(t)) -> y_IS1(t) from the first pair and
corrects the twin's run of the second. Prints both RMS errors.
"""

from __future__ import annotations

import sys

import gpytorch
import h5py
import numpy as np
import torch
from numpy.typing import NDArray

Pair = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]


def read_pairs(path: str) -> list[Pair]:
    """Time, twin and axis of each pair."""
    with h5py.File(path, "r") as file:
        trials = file["trials"]
        twins = [trial for trial in trials.values() if trial.attrs["source"] == "IS2"]
        pairs = []
        for twin in twins:
            axis = trials[f"{twin.attrs['parent']:06d}"]
            assert axis.attrs["source"] == "IS1"
            assert list(axis.attrs["gains"]) == list(twin.attrs["gains"])
            pairs.append((twin["time"][:], twin["position"][:], axis["position"][:]))
        return pairs


class Correction(gpytorch.models.ExactGP):  # type: ignore[misc]
    """Gaussian process with one length scale for time and one for the twin's position."""

    def __init__(
        self,
        x: torch.Tensor,
        y: torch.Tensor,
        likelihood: gpytorch.likelihoods.GaussianLikelihood,
    ) -> None:
        super().__init__(x, y, likelihood)
        self.mean = gpytorch.means.ConstantMean()
        kernel = gpytorch.kernels.MaternKernel(nu=2.5, ard_num_dims=2)
        self.kernel = gpytorch.kernels.ScaleKernel(kernel)

    def forward(self, x: torch.Tensor) -> gpytorch.distributions.MultivariateNormal:
        return gpytorch.distributions.MultivariateNormal(self.mean(x), self.kernel(x))


def correct(learn: Pair, apply: Pair) -> NDArray[np.float64]:
    """Train on one pair, every fifth sample, and correct the twin of the other."""
    mean = np.array([learn[0].mean(), learn[1].mean()])
    std = np.array([learn[0].std(), learn[1].std()])

    def inputs(pair: Pair) -> torch.Tensor:
        return torch.tensor((np.column_stack(pair[:2]) - mean) / std)

    x, y = inputs(learn)[::5], torch.tensor((learn[2] - learn[2].mean()) / learn[2].std())[::5]
    likelihood = gpytorch.likelihoods.GaussianLikelihood()
    model = Correction(x, y, likelihood).double()
    objective = gpytorch.mlls.ExactMarginalLogLikelihood(likelihood, model)
    optimiser = torch.optim.Adam(model.parameters(), lr=0.1)
    for _ in range(100):
        optimiser.zero_grad()
        loss = -objective(model(x), y)
        loss.backward()
        optimiser.step()
    model.eval()
    with torch.no_grad():
        corrected: NDArray[np.float64] = model(inputs(apply)).mean.numpy()
    restored: NDArray[np.float64] = corrected * learn[2].std() + learn[2].mean()
    return restored


def main(path: str) -> None:
    """Print the RMS error of the twin and of the corrected twin on the second pair."""
    learn, apply = read_pairs(path)[:2]
    corrected = correct(learn, apply)
    rms = [float(np.sqrt(np.mean((y - apply[2]) ** 2))) for y in (apply[1], corrected)]
    assert "gmfbo" not in sys.modules
    print(f"{rms[0]:.6f} {rms[1]:.6f}")


if __name__ == "__main__":
    torch.set_num_threads(1)
    main(sys.argv[1])
