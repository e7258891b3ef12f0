# ---
# jupyter:
#   jupytext:
#     formats: py:percent,ipynb
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # Reading the store
#
# A study keeps every trajectory of every source in HDF5. You need nothing of gmfbo to read it: any
# HDF5 reader will do, also in MATLAB. Here plain `h5py` reads a study, and plain `gpytorch` trains
# on it what gmfbo calls the correction: a Gaussian process that knows how the real axis (IS1)
# differs from its twin (IS2). A real run that it has not seen is the test.
#
# First there must be a study: eight runs of a robot joint whose twin has 50 % noise in the flux map
# of its motor. The real joint is played by an FMU.

# %%
from __future__ import annotations

import json
import tempfile
from pathlib import Path

import gpytorch
import h5py
import numpy as np
import torch

from gmfbo import NotebookFigure, Study, Tuner, models_folder

folder = Path(tempfile.mkdtemp(prefix="gmfbo-store-"))
STUDY = f"""
method = "gmfbo_paper"
[is1]
twin = '{models_folder() / "drive_twin.toml"}'
[is2]
twin = '{models_folder() / "drive_twin.toml"}'
parameters = {{ "map.noise" = 0.5 }}
[reference]
step = 1.0
at = 0.1
horizon = 0.4
[objective]
normalise = 4
[budget]
initial_is1 = 8
initial_is2 = 4
is1_runs = 8
is3_per_run = 1
"""
(folder / "joint.toml").write_text(STUDY, encoding="utf-8")
with Tuner(Study.read(folder / "joint.toml")) as tuner:
    tuner.run()

# %% [markdown]
# ## What is in it
#
# From here on gmfbo is not used. `index.h5` shows all trials as one file by links to
# `trials/000001.h5` and so on; `gmfbo export joint.study --pack joint.h5` makes one file to send
# to somebody. A trial is one run of one source. Its datasets are columns over time:

# %%
DATASETS = {
    "time": "when each sample was taken; the first one need not be at zero",
    "reference": "what the axis is asked to follow",
    "position": "what was reached: the signal that is scored",
    "torque_command": "what the controller asked of the drive",
    "velocity": "of the joint",
    "position_uncorrected": "IS3 alone: the twin's position before it was corrected",
    "position_std": "IS3 alone: standard deviation of the corrected position",
}
ATTRIBUTES = {
    "source": "IS1 real axis, IS2 its twin, IS3 the corrected twin",
    "gains": "values of the gains [unit of the FMU parameter]",
    "gain_names": "their names, in the same order",
    "objective": "cost g, less is better",
    "metric.rise_time": "[s]; one attribute for each metric",
    "status": "ok, or how the run ended early",
    "seconds": "wall clock that the run took [s]",
    "parent": "the real run that this run of the twin was made for; real runs have none",
}

store = h5py.File(folder / "joint.study" / "index.h5")
trials = store["trials"]
kinds = {source: [t for t in trials.values() if t.attrs["source"] == source]
         for source in ("IS1", "IS2", "IS3")}  # fmt: skip
print({source: len(found) for source, found in kinds.items()})
for name, meaning in DATASETS.items():
    holders = [t[name] for t in trials.values() if name in t]
    rows, unit = holders[0].shape[0], holders[0].attrs.get("unit", "")
    print(f"{name:21}{rows:5} x [{unit:5}] in {len(holders):2} trials: {meaning}")
for name, meaning in ATTRIBUTES.items():
    print(f"{name:21}{meaning}")

# %% [markdown]
# All others (versions of the software, hash of the twin, seed, date ...) are in
# [the store](docs/store.md). What happened when stands in `events.jsonl`, a line of JSON each.

# %%
with (folder / "joint.study" / "events.jsonl").open(encoding="utf-8") as log:
    events = [json.loads(line)["event"] for line in log]
print({event: events.count(event) for event in sorted(set(events))})

# %% [markdown]
# ## Pairs of real run and twin
#
# After each real run the twin was run at the same gains; its `parent` is the number of that real
# run. The difference of the two is what there is to learn.

# %%
real = {int(t.attrs["number"]): t for t in kinds["IS1"]}
pairs = [(real[int(t.attrs["parent"])], t) for t in kinds["IS2"] if "parent" in t.attrs]
gains = np.array([axis.attrs["gains"] for axis, _ in pairs])
scaled = (gains - gains.min(axis=0)) / np.ptp(gains, axis=0)
left_out = int(np.argmin(np.linalg.norm(scaled - scaled.mean(axis=0), axis=1)))
names = list(pairs[0][0].attrs["gain_names"])
print(f"{len(pairs)} pairs; left out, in their midst:",
      ", ".join(f"{n} = {v:.1f}" for n, v in zip(names, gains[left_out], strict=True)))  # fmt: skip


def inputs_and_error(pair: int, every: int) -> tuple[torch.Tensor, torch.Tensor]:
    """Time, twin's position and gains, (n, 4); real less twin's position, (n,) [rad]."""
    axis, twin = pairs[pair]
    time, simulated = twin["time"][::every], twin["position"][::every]
    columns = [time / 0.1, simulated, *(np.full_like(time, value) for value in scaled[pair])]
    return torch.tensor(np.stack(columns, axis=1)), torch.tensor(
        axis["position"][::every] - simulated
    )


# %% [markdown]
# ## A correction of one's own
#
# A Gaussian process from time, twin's position and gains to the error of the twin: Matérn 5/2, a
# lengthscale for each input, fitted by maximum likelihood to every 12th sample of seven pairs.


# %%
class Correction(gpytorch.models.ExactGP):
    """Error of the twin over time, its own position, and the gains."""

    def __init__(self, x: torch.Tensor, y: torch.Tensor) -> None:
        super().__init__(x, y, gpytorch.likelihoods.GaussianLikelihood().double())
        self.mean_module = gpytorch.means.ZeroMean()
        matern = gpytorch.kernels.MaternKernel(nu=2.5, ard_num_dims=4)
        self.covar_module = gpytorch.kernels.ScaleKernel(matern)

    def forward(self, x: torch.Tensor) -> gpytorch.distributions.MultivariateNormal:
        return gpytorch.distributions.MultivariateNormal(self.mean_module(x), self.covar_module(x))


learned = [inputs_and_error(pair, 12) for pair in range(len(pairs)) if pair != left_out]
x, y = (torch.cat(parts) for parts in zip(*learned, strict=True))
torch.manual_seed(0)
model = Correction(x, y).double()
likelihood = gpytorch.mlls.ExactMarginalLogLikelihood(model.likelihood, model)
adam = torch.optim.Adam(model.parameters(), lr=0.1)
model.train()
for _ in range(80):
    adam.zero_grad()
    loss = -likelihood(model(x), y)
    loss.backward()
    adam.step()
print(f"{len(x)} samples; lengthscales of time, position, gains:",
      model.covar_module.base_kernel.lengthscale.detach().numpy().round(2)[0])  # fmt: skip

# %% [markdown]
# ## The run that it has not seen

# %%
model.eval()
axis, twin = pairs[left_out]
time, measured, simulated = twin["time"][:], axis["position"][:], twin["position"][:]
with torch.no_grad():
    belief = model.likelihood(model(inputs_and_error(left_out, 1)[0]))
    corrected = simulated + belief.mean.numpy()
    band = 1.96 * belief.stddev.numpy()


def rms(error: np.ndarray) -> float:
    """[mrad]"""
    return 1e3 * float(np.sqrt(np.mean(error**2)))


alone, with_correction = rms(measured - simulated), rms(measured - corrected)
print(f"left-out real run: twin alone {alone:.1f} mrad off (RMS), corrected {with_correction:.1f}")

figure = NotebookFigure(figsize=(6.4, 4.4), layout="constrained")
above, below = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
above.plot(time, measured, color="black", linewidth=2.4, alpha=0.5, label="real, left out")
above.plot(time, simulated, "--", color="#d55e00", label="twin alone")
above.plot(time, corrected, color="#009e73", label="twin, corrected (95 % band)")
above.fill_between(time, corrected - band, corrected + band, color="#009e73", alpha=0.2)
above.set_ylabel("position [rad]")
above.legend(frameon=False, loc="lower right")
below.plot(time, measured - simulated, "--", color="#d55e00")
below.plot(time, measured - corrected, color="#009e73")
below.set(xlabel="time [s]", ylabel="error [rad]")
figure  # noqa: B018

# %% [markdown]
# What this page claims:

# %%
assert set(DATASETS) == {name for trial in trials.values() for name in trial}, "each is explained"
assert all(name in trial.attrs for trial in kinds["IS3"] for name in ATTRIBUTES)
assert len(pairs) == len(real) == 8
assert with_correction < 0.5 * alone, "the correction predicts a real run that it has not seen"
store.close()
