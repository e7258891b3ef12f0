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
# # The paper's studies
#
# Guided multi-fidelity Bayesian optimisation (Nobar et al. 2025, arXiv:2509.17952) was judged on a
# robot's joint drive and a twin of it whose lookup table, the flux map of the motor, is 25, 50 or
# 75 % noise. Three questions were asked at each level: how wrong is the twin about the objective,
# what do runs cost, and how fast does the best observed gain descend with the runs of the real
# drive (IS1)? Here they are asked of this project's own drive and code; its numbers are not those
# of the paper, whose drive data are not public.
#
# As it stands the page runs a small version, in a minute: few seeds, few runs, a coarse grid. It
# shows what is measured and how to read it; it cannot say which method is better. For the whole
# studies set `GMFBO_STUDIES` to a folder that shall keep them. They take many hours; every finished
# run is kept, so they go on where they were stopped, and
#
# `gmfbo compare tests/benchmarks/studies/noise_50.toml --seeds 30 --out FOLDER/noise_50`
#
# with `--methods` as below makes the same on all processors.

# %%
from __future__ import annotations

import os
import tempfile
from pathlib import Path

import numpy as np

from gmfbo import Comparison, NotebookFigure, compare, models_folder
from gmfbo.reports.figures.comparison_figures import best_observed, sampling_cost
from gmfbo.reports.figures.figure_map import draw_map
from gmfbo.studies.curves import read_curves
from gmfbo.studies.landscape import read_landscape

BENCHMARKS = models_folder().parent / "tests" / "benchmarks"
LEVELS = (25, 50, 75)  # [%] noise in the nodes of the twin's flux map, of the table's range
whole = os.environ.get("GMFBO_STUDIES")
if whole:
    folder = Path(whole)
    methods, seeds, grid = ["gmfbo_physics", "gmfbo", "gmfbo_paper", "mfbo_takg", "bo_ei"], 30, 41
else:
    folder = Path(tempfile.mkdtemp(prefix="gmfbo-paper-"))
    methods, seeds, grid = ["gmfbo_paper", "bo_ei"], 2, 7


def study_file(level: int) -> Path:
    """The study of a noise level; in the small version with a small budget."""
    path = BENCHMARKS / "studies" / f"noise_{level}.toml"
    if whole:
        return path
    text = path.read_text(encoding="utf-8")
    for given, small in (
        ("is1_runs = 22", "is1_runs = 4"),
        ("iterations = 100", "iterations = 5"),
        ('"../../../models/', f'"{models_folder().as_posix()}/'),
    ):
        assert given in text
        text = text.replace(given, small)
    copy = folder / path.name
    copy.write_text(text, encoding="utf-8")
    return copy


# %% [markdown]
# ## Run them
#
# Each method begins with the same two real runs and ten twin runs of a seed. The seed also draws
# the noise. The true optimum comes from running the plant over a grid of gains.

# %%
results = {
    level: compare(study_file(level), methods, seeds, grid=grid, out=folder / f"noise_{level}")
    for level in LEVELS
}
landscapes = {level: read_landscape(results[level].folder / "landscape.txt") for level in LEVELS}
curves = {level: read_curves(results[level].folder / "curves.txt") for level in LEVELS}

# %% [markdown]
# ## How wrong is the twin?
#
# First the true objective over the gains, less is better; the star is the best. Then the error of
# the twin's objective relative to the real one, |G2 - G1| / G1, at three levels of noise. (G is the
# objective without its mean subtracted, so that a share of it has a meaning.) Mind the scales. The
# twin is relatively most wrong around the best gains, where the real objective is small.

# %%
figure = NotebookFigure(figsize=(8.0, 6.0), layout="constrained")
panels = figure.subplots(2, 2, sharex=True, sharey=True).flatten()
true = landscapes[50]
draw_map(panels[0], true.x, true.y, true.objective, "true objective g [1]", "viridis")
for axes, (level, seen) in zip(panels[1:], landscapes.items(), strict=True):
    draw_map(axes, seen.x, seen.y, seen.error, f"twin's error at {level} % noise [%]", "magma_r")
row, column = np.unravel_index(np.argmin(true.objective), true.objective.shape)
for axes in panels:
    axes.plot(true.x[row], true.y[column], "w*", markeredgecolor="k", markersize=11)
for below, beside in zip(panels[2:], panels[::2], strict=True):
    below.set_xlabel("ctl.Kp [N m/rad]")
    beside.set_ylabel("ctl.Kd [N m s/rad]")
errors = {level: float(np.median(seen.error)) for level, seen in landscapes.items()}
for level, error in errors.items():
    print(f"{level} % noise: the twin's objective is off by {error:.0f} % (median over the gains)")
figure  # noqa: B018

# %% [markdown]
# ## What do runs cost?
#
# A run of the real drive counts one; a run of the twin (IS2), or of the corrected twin (IS3), a
# tenth. `bo_ei` asks the real drive alone: one a query. A query of `gmfbo_paper` may go to the
# twin; each of its real runs brings a twin run beside it and four corrected ones.

# %%
sampling_cost(curves[50])

# %% [markdown]
# ## How fast does it descend?
#
# The best observed objective against runs of the real drive, mean over seeds with a 95 % interval
# (bootstrap), and how much is left of the way to the optimum: the dotted line, 2 %, counts as
# arrived. A curve ends with the shortest run among its seeds: who asks the twin has made fewer real
# runs when the queries are used up.

# %%
best_observed(curves[25])

# %%
best_observed(curves[50])

# %%
best_observed(curves[75])

# %% [markdown]
# n* is the number of real runs until a seed has arrived; in the small version hardly any does.

# %%
print(results[50].text.split("\n\n")[1])

# %% [markdown]
# ## The whole studies
#
# Results of whole studies are kept with the project, in `tests/benchmarks/results`: the tables, the
# runs they follow from, and the command that goes on with them. They are drawn here. Two more
# questions are asked there: what if the drive changes (its friction doubles after the fourth real
# run; n* counts these four), and what if the twin lacks physics altogether?

# %%
WHOLE = {
    "noise_25": "25 % noise in the twin's flux map",
    "noise_50": "50 % noise",
    "noise_75": "75 % noise",
    "friction_doubling": "50 % noise, and the drive's friction doubles after the fourth real run",
    "missing_physics": "friction, backlash, cogging or delay that the twin lacks, one or two",
    "wrong_structure": "a velocity filter that the twin lacks and no known effect describes",
    "hardware_like": "more friction, backlash and delay, in the box of a hardware study",
}
kept = {
    name: Comparison.read(BENCHMARKS / "results" / name)
    for name in WHOLE
    if (BENCHMARKS / "results" / name / "curves.txt").is_file()
}
for name, result in kept.items():
    print(f"{WHOLE[name]}\n" + result.text.split("\n\n")[1] + "\n")
    result.draw(folder / f"kept_{name}")  # SVG, PDF and PNG, for a paper
if not kept:
    print("no tables of whole studies here")
whole_curves = {name: read_curves(result.folder / "curves.txt") for name, result in kept.items()}

# %%
best_observed(whole_curves["noise_50"]) if "noise_50" in kept else None

# %%
best_observed(whole_curves["friction_doubling"]) if "friction_doubling" in kept else None

# %%
best_observed(whole_curves["missing_physics"]) if "missing_physics" in kept else None

# %%
sampling_cost(whole_curves["noise_50"]) if "noise_50" in kept else None

# %% [markdown]
# What this page claims: the twin is the more wrong the more noise its table has; the methods start
# from the same data, and what is best observed never gets worse; without the twin each query costs
# a real run, with it less than a real run with all that comes with it (1.5).

# %%
assert errors[25] < errors[50] < errors[75]
for level in LEVELS:
    found = {(curve.method, curve.name): curve for curve in curves[level]}
    for method in methods:
        best = found[method, "objective"]
        assert (np.diff(best.mean) <= 1e-9).all()
        np.testing.assert_allclose(best.mean[:2], found["bo_ei", "objective"].mean[:2])
        assert ((best.low <= best.mean) & (best.mean <= best.high)).all()
    alone, guided = found["bo_ei", "cost"], found["gmfbo_paper", "cost"]
    np.testing.assert_allclose(np.diff(alone.mean), 1.0)
    np.testing.assert_allclose(alone.mean[0], 2.0 + 10 * 0.1)
    assert np.diff(guided.mean).mean() < 1.5 + 1e-9
    made = {(one.method, one.seed) for one in results[level].outcomes}
    assert {(method, seed) for method in methods for seed in range(seeds)} <= made
    assert not results[level].failed
