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
# # A first tuning
#
# A robot joint is driven with gains that somebody found by hand. It is slow. There is a digital
# twin of it, and the twin is almost right: the flux map of its motor is half noise. How much better
# can the joint be, and how few runs of the real one does it take to know?
#
# Here an FMU plays the real joint, so that this page runs anywhere. With your own axis only the
# lines under `[is1]` change: [your own rig](05_your_own_rig.py).

# %%
from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from gmfbo import NotebookFigure, Study, Tuner, models_folder
from gmfbo.reports.figures.study_figures import best_observed, gains
from gmfbo.reports.figures.trajectory_figure import trajectories
from gmfbo.reports.study.review import StudyReview
from gmfbo.tuning.query.progress import Progress

folder = Path(tempfile.mkdtemp(prefix="gmfbo-first-"))

# %% [markdown]
# ## Say what is to be tuned
#
# A study is a text file. This one: five runs of the joint, each a step of 1 rad, the first at the
# gains in use. What a good step is stands under `weights`: mostly a short rise, then a short
# settling, and little overshoot. (These weights hold unless others are given.) The twin file
# `drive_twin.toml` names the gains and how far they may go.

# %%
STUDY = f"""
name = "joint"
seed = 0
method = "gmfbo"

[is1]                              # the real joint
twin = '{models_folder() / "drive_twin.toml"}'
[is2]                              # its twin, almost right
twin = '{models_folder() / "drive_twin.toml"}'
parameters = {{ "map.noise" = 0.5, "map.seed" = "seed" }}
[reference]
step = 1.0                         # [rad]
at = 0.1                           # [s]
horizon = 0.5                      # [s] after the step
[objective]
weights = {{ overshoot = 0.02, transient_time = 0.20, rise_time = 0.70, settling_time = 0.20 }}
[safety]
start = [[60.0, 6.0]]              # Kp [N.m/rad] and Kd [N.m.s/rad] in use now: run first
[budget]
is1_runs = 5
"""
file = folder / "joint.toml"
file.write_text(STUDY, encoding="utf-8")

# %% [markdown]
# ## Tune it
#
# The twin is run all over the range of the gains first; that costs the joint nothing. Then each run
# of the joint teaches how the twin errs, and the next gains are chosen with what was learned.


# %%
def tell(step: Progress) -> None:
    """A line for each run of the real joint."""
    if step.source == "IS1" and step.phase in ("initial", "query"):
        at = ", ".join(f"{name} = {value:.4g}" for name, value in step.gains.items())
        print(f"real run {step.is1_runs}: {at}: objective {step.objective:.2f}")


with Tuner(Study.read(file)) as tuner:
    result = tuner.run(tell)
assert result.best is not None
assert result.recommendation is not None

# %% [markdown]
# ## Read the result
#
# The objective is dimensionless, and less is better: zero is what the twin does at gains taken at
# random, minus one is about one standard deviation better than that. Judge by the metrics, which
# have units. A time of 0.5 s means "not within this run". The metrics and their definitions are in
# [tuning](docs/tuning.md#metrics).

# %%
review = StudyReview.read(folder / "joint.study")
real = [run.trial for run in review.real]
start, best = real[0], result.best
print(f"{'':16}{'in use':>10}{'tuned':>10}")
for name in best.gains:
    print(f"{name:16}{start.gains[name]:10.1f}{best.gains[name]:10.1f}")
for name, unit in (("rise_time", "s"), ("settling_time", "s"), ("overshoot", "%")):
    print(f"{name:16}{start.metrics[name]:10.3f}{best.metrics[name]:10.3f} {unit}")
print(f"{len(real)} runs of the real joint, {len(review.of('IS2'))} of the twin")

# %%
figure = NotebookFigure(figsize=(6.4, 3.2), layout="constrained")
axes = figure.add_subplot()
reference = best.recording.signal("reference")
axes.plot(best.recording.time, reference, ":", color="0.4", label="reference")
for trial, colour, dashes, label in (
    (start, "#d55e00", "--", "gains in use"),
    (best, "#0072b2", "-", "tuned"),
):
    axes.plot(
        trial.recording.time, trial.recording.signal("position"), dashes, color=colour, label=label
    )
axes.set(xlabel="time [s]", ylabel="position of the joint [rad]")
axes.legend(frameon=False)
figure  # noqa: B018

# %% [markdown]
# How the best came about, run by run. The right panel counts the twin's runs too, each as a tenth
# of a real one: with a twin as fast as this one they are a matter of seconds.

# %%
best_observed(review)

# %% [markdown]
# Where the runs were. The shades are the twin's objective, the circles the real runs. The best one
# lies inside the range of both gains. At a limit, the range would ask to be widened.

# %%
gains(review)

# %% [markdown]
# The best run with the twin's at the same gains. What is left between real and twin, in the lower
# panel, is what the correction learns from.

# %%
trajectories(review)

# %% [markdown]
# ## The same by command line
#
# `gmfbo tune joint.toml` runs the file from its beginning, and prints a bar while it does. Here it
# goes on where Python stopped (`--resume`), by a sixth run. `gmfbo report` writes a page that
# opens in any browser without a network; click on a run in it to see its curves.


# %%
def gmfbo(*words: str) -> str:
    """Run the program and return what it prints, without the colours that a kernel asks for."""
    command = [sys.executable, "-m", "gmfbo", *words]
    plain = {name: value for name, value in os.environ.items() if name != "FORCE_COLOR"}
    done = subprocess.run(
        command, check=True, capture_output=True, text=True, cwd=folder, env=plain
    )
    return done.stdout


file.write_text(STUDY.replace("is1_runs = 5", "is1_runs = 6"), encoding="utf-8")
print("$ gmfbo tune joint.toml --resume")
print(gmfbo("tune", "joint.toml", "--resume"))
print("$ gmfbo report joint.study --out joint.html")
print(gmfbo("report", "joint.study", "--out", "joint.html"))

# %% [markdown]
# What this page claims: five runs of the real joint, the one at the gains in use among them, were
# enough for less than half of the rise time and of the settling time at little overshoot; the
# command line goes on with the same study.

# %%
costs = np.array([trial.objective for trial in real])
better_after = int(np.argmax(costs < costs[0])) + 1
best_is = int(np.argmin(costs)) + 1
print(f"better than the gains in use from real run {better_after} on; the best is run {best_is}")

assert dict(start.gains) == {"ctl.Kp": 60.0, "ctl.Kd": 6.0}
assert len(real) == 5
assert best.objective < start.objective - 1.0
assert best.metrics["rise_time"] < 0.5 * start.metrics["rise_time"]
assert best.metrics["settling_time"] < 0.5 * start.metrics["settling_time"]
assert best.metrics["overshoot"] < 10.0
after = [trial for trial in Study.read(folder / "joint.study").trials if trial.source == "IS1"]
assert [trial.objective for trial in after[:5]] == costs.tolist()
assert len(after) == 6
assert (folder / "joint.html").stat().st_size > 100_000
