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
# # Add an effect, a metric, a method
#
# Three places where your knowledge goes in, and nothing of gmfbo is changed for any of them:
#
# - an **effect**: physics that the diagnosis does not know yet;
# - a **metric**: what a good run is on your machine;
# - a **method**: how the next gains are chosen.

# %%
from __future__ import annotations

import os
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gmfbo import (
    AugmentedTwin,
    FmuTwin,
    NotebookFigure,
    Recording,
    Study,
    Tuner,
    compare,
    diagnose,
    models_folder,
    write_recording,
)
from gmfbo.physics import Effect, Excitation, add_effect
from gmfbo.physics.effect import positive
from gmfbo.physics.units import quantity
from gmfbo.reports.figures.comparison_figures import best_observed
from gmfbo.studies.curves import read_curves
from gmfbo.tuning.method import Proposal

folder = Path(tempfile.mkdtemp(prefix="gmfbo-mine-"))
AXIS = models_folder() / "servo_axis.toml"

# %% [markdown]
# ## An effect: a bellows that stiffens
#
# A rubber bellows pulls the axis back, with the cube of the angle. gmfbo knows springs, but none
# like this one. First its law, in C. `build_physics` compiles it together with all the laws that
# gmfbo has (`pip install "gmfbo[build]"` brings the compiler), and `GMFBO_PHYSICS` says where that
# is. The sources of those laws come with a checkout of gmfbo, not with an installed package.

# %%
sys.path.append(str(models_folder().parent))
from fmu_build.own_effect import build_physics  # noqa: E402

LAW = """
static inline double cubic_spring(const double *v, const Signals *s) {
    return -v[V_cubic_spring_stiffness] * s->position * s->position * s->position;
}
"""
physics = build_physics(
    folder / "physics.fmu", "cubic_spring", LAW, {"stiffness": "Torque per position cubed"}
)
os.environ["GMFBO_PHYSICS"] = str(physics)

# %% [markdown]
# Then what the diagnosis must know: how large it may be, below which size it is not worth a word,
# what it does on a given motion, where it acts, and how to say so. Each entry is explained in
# `gmfbo/physics/effect.py`.


# %%
def whole(excitation: Excitation) -> float:
    """[N.m/rad3] Half a stroke from zero, such a spring takes all the torque that was recorded."""
    return excitation.torque / (0.5 * excitation.stroke) ** 3


add_effect(
    Effect(
        name="cubic_spring",
        port="torque",
        family="spring",
        signal_path="plant",
        parameters=(positive("stiffness", "Stiffness", "torque/position3", whole),),
        starts=lambda e: [{"stiffness": 0.07 * whole(e)}],
        size=lambda p, e: p["stiffness"],
        size_name="stiffness",
        size_unit="torque/position3",
        floor=lambda e: 1.5e-4 * whole(e),
        signal=lambda states, p: -p["stiffness"] * states.position**3,
        feature=lambda states: -(states.position**3),
        acts=lambda states, p: abs(states.position) > 0.5 * abs(states.position).max(),
        region=lambda p, units: "at the ends of the position range",
        region_state="position",
        statement=lambda p, units, place: (
            f"A bellows of about {quantity(p['stiffness'], units.resolve('torque/position3'))} "
            f"{place} is missing from the twin."
        ),
        equation="tau = -k * phi^3",
        source="Duffing, 1918",
    )
)

# %% [markdown]
# Three recordings of an axis with such a bellows, 2 N m/rad³, and 5 % more inertia than the twin
# says; the encoder is noisy. The twin knows of no bellows.

# %%
BELLOWS = 2.0  # [N.m/rad3]
time, rng = np.arange(600) * 1e-3, np.random.default_rng(0)
with AugmentedTwin(FmuTwin(AXIS), substeps=10) as axis:
    for number, (hertz, size) in enumerate([(1.2, 0.5), (1.8, 0.35), (2.5, 0.6)]):
        turn = 2.0 * np.pi * hertz * time
        wave = {"reference": size * (0.7 * np.sin(turn) + 0.3 * np.sin(2.6 * turn))}
        plan = axis.plan(Recording(time=time, signals=wave), {})
        noise = 3e-5 * rng.standard_normal(time.size)  # [rad]
        run = axis.run(
            plan,
            {"inertia": 0.0105},
            {"cubic_spring.stiffness": BELLOWS},
            excitation={"sensor": noise},
        )
        logged = {**wave, **run.held, "position": run.states["position"] + noise}
        write_recording(Recording(time=time, signals=logged), folder / f"run{number}.csv")

recordings = sorted(folder.glob("run?.csv"))
found = diagnose(AXIS, recordings[:2], recordings[2:])
print(found)

# %% [markdown]
# The law is also in the corrected twin, which runs in any FMI tool; its size is a parameter there.

# %%
found.save(folder / "found")
with FmuTwin(folder / "found" / "augmented.toml") as better:
    followed = better.run({}, Recording.read(recordings[2], better))
    sizes = [name for name in better.binding.variables if name.startswith("physics.")]
print(sizes, followed.status)

# %% [markdown]
# The same without it in the library: something is missing that no known law explains, and the
# nearest laws are called no more than that. What is left is a curve over the position, which shows
# what kind of law to write. A curve is no equation, though: it says nothing beyond the positions
# that were reached, and goes into no FMU.

# %%
without = diagnose(AXIS, recordings[:2], recordings[2:], exclude=["cubic_spring"])
print(without)


left = found.fit.signals["torque_command"]  # errors on the recording that no fit has seen


figure = NotebookFigure(figsize=(6.8, 2.6), layout="constrained")
axes = figure.add_subplot()
rows = [
    ("twin, refitted", 100.0 * left.parameters_only, "0.6"),
    ("your own law", 100.0 * left.augmented, "#0072b2"),
    ("noise floor", 100.0 * left.noise_floor, "0.8"),
]
axes.barh([row[0] for row in rows], [row[1] for row in rows], color=[row[2] for row in rows])
for place, row in enumerate(rows):
    axes.text(row[1], place, f" {row[1]:.2f} %", va="center")
axes.set(xlabel="error of the torque command on the unseen recording [% of its range]")
axes.margins(x=0.2)
axes.invert_yaxis()
figure  # noqa: B018

# %% [markdown]
# ## A metric: the torque that a step costs
#
# A Python function of a run. The study file names it, and weighs it beside the others.

# %%
MINE = '''
import numpy as np


def effort(run):
    """RMS torque [N.m]."""
    return float(np.sqrt(np.mean(run.signal("torque_command") ** 2)))
'''
(folder / "mine.py").write_text(MINE, encoding="utf-8")

STUDY = f"""
name = "gentle"
seed = 0
[is1]
twin = '{AXIS}'
parameters = {{ "inertia" = 0.013 }}
[is2]
twin = '{AXIS}'
[reference]
step = 0.2                         # [rad]
at = 0.05                          # [s]
horizon = 0.4                      # [s]
[objective]
metrics = "mine.py:effort"
weights = {{ rise_time = 0.6, settling_time = 0.2, effort = 0.2 }}
normalise = 4
[budget]
initial_is2 = 4
is1_runs = 6
"""
(folder / "gentle.toml").write_text(STUDY, encoding="utf-8")

# %% [markdown]
# ## A method: turn the knobs near the best
#
# What a patient engineer does: try near the best gains so far, in ever smaller steps. A method is
# given all that was observed, gains scaled to [0, 1], and says what to run next. It keeps nothing
# to itself, so that a study can be stopped and gone on with.


# %%
@dataclass(frozen=True)
class TurnTheKnobs:
    """Random steps around the best real run, smaller each time."""

    name: str = "turn_the_knobs"
    summary: str = "random steps around the best real run, smaller each time"
    reference: str = "this page"
    correction: None = None  # it wants no corrected runs of the twin

    def propose(self, state, rng):
        best, _, _ = self.recommend(state)
        reach = 0.5 * 0.85 ** len(state.of("IS1"))
        return Proposal("IS1", np.clip(best + reach * rng.standard_normal(best.size), 0.0, 1.0))

    def recommend(self, state):
        best = min(state.of("IS1"), key=lambda seen: seen.objective)
        return best.point, best.objective, 0.0


with Tuner(Study.read(folder / "gentle.toml"), method=TurnTheKnobs()) as tuner:
    result = tuner.run()
assert result.best is not None
trials = Study.read(folder / "gentle.study").trials
for trial in trials:
    if trial.source == "IS1":
        gains = ", ".join(f"{name} = {value:5.1f}" for name, value in trial.gains.items())
        rise, effort = 1e3 * trial.metrics["rise_time"], trial.metrics["effort"]
        print(f"{gains}: rise {rise:3.0f} ms, effort {effort:.2f} N m, cost {trial.objective:5.2f}")

# %% [markdown]
# Is it any good? `compare` runs it beside Bayesian optimisation (`bo_ei`), on the same seeds and
# initial runs. Two seeds show that it works, not which is better: the bands tell.

# %%
comparison = compare(folder / "gentle.toml", [TurnTheKnobs(), "bo_ei"], seeds=2, grid=5)
print(comparison.text.partition("\n\nthe same within")[0])
best_observed(read_curves(comparison.folder / "curves.txt"))

# %% [markdown]
# To have both by name on the command line, in study files and for your colleagues, put them into a
# package of your own with these lines in its `pyproject.toml`:
#
# ```toml
# [project.entry-points."gmfbo.effects"]
# cubic_spring = "my_package:cubic_spring"
# [project.entry-points."gmfbo.methods"]
# turn_the_knobs = "my_package:TurnTheKnobs"
# ```
#
# What this page claims:

# %%
(named,) = found.effects
assert named.name == "cubic_spring"
assert abs(named.parameters["stiffness"].value - BELLOWS) < 0.05 * BELLOWS
assert sizes == ["physics.cubic_spring.stiffness"]
assert followed.status == "ok"
assert without.verdict == "outside_library"
assert all(effect.set_probability <= 0.8 for effect in without.effects)  # the nearest
assert without.shape is not None
assert without.shape.against == "position"
assert ("cubic_spring", "excluded by the user") in {(n.name, n.why) for n in without.not_testable}
assert left.augmented < 0.2 * left.parameters_only

assert all(trial.metrics["effort"] > 0.0 for trial in trials)
made = {(one.method, one.seed): one for one in comparison.outcomes}
assert set(made) == {(name, seed) for name in ("turn_the_knobs", "bo_ei") for seed in range(2)}
for seed in range(2):
    mine, theirs = made["turn_the_knobs", seed], made["bo_ei", seed]
    assert mine.best[:2] == theirs.best[:2], "the same initial runs"
    assert mine.best[-1] < mine.best[1], "and better after six"
print(f"found: {named.statement}")
