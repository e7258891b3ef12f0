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
# # Swap in a vendor's FMU
#
# A twin is an FMU and a text file. So a vendor's FMU takes the place of yours by writing a twin
# file, and a study goes over to it by changing one line. The vendor here is OpenModelica:
# `Mass_Damper` of the package `gemseo-fmu` is a mass with spring and damper that a force moves. It
# has no controller, and its one output is named `y` and has no unit.

# %%
from __future__ import annotations

import difflib
import importlib.metadata
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from gmfbo import FmuTwin, Recording, Study, Tuner, models_folder

MODELS = models_folder()
folder = Path(tempfile.mkdtemp(prefix="gmfbo-vendor-"))

try:
    package = importlib.metadata.distribution("gemseo-fmu")
except importlib.metadata.PackageNotFoundError:
    # Without what it depends on: only its FMUs are used.
    sys.exit("first: pip install --no-deps gemseo-fmu")
system = {"linux": "linux", "win32": "win32"}.get(sys.platform, "none")
vendor_fmu = Path(
    str(package.locate_file(f"gemseo_fmu/problems/fmu_files/{system}/Mass_Damper.fmu"))
)
if not vendor_fmu.is_file():
    sys.exit("gemseo-fmu has FMUs for Linux and Windows only")

# %% [markdown]
# ## What is it?
#
# `gmfbo inspect` reads the file and runs none of its code. `--twin-file` writes a twin file to
# start from. What gmfbo guesses from units, names and causality stands there as a comment with its
# reason; nothing is switched on that you have not looked at.


# %%
def gmfbo(*words: str | Path) -> str:
    """Run the program and return what it prints, without the colours that a kernel asks for."""
    command = [sys.executable, "-m", "gmfbo", *map(str, words)]
    plain = {name: value for name, value in os.environ.items() if name != "FORCE_COLOR"}
    done = subprocess.run(
        command, check=True, capture_output=True, text=True, cwd=folder, env=plain
    )
    return done.stdout


starting_twin = gmfbo("inspect", "--twin-file", vendor_fmu)
print(starting_twin)

# %% [markdown]
# The guesses are right here: position and velocity are local variables of the model, physics may
# add to the force, the mass is the inertia. The last lines show how a controller of gmfbo closes
# the loop. So the twin file is:

# %%
LOOP = """
name = "{name}"
step = 1e-3
[fmus]
controller = {{ kind = "pd_filtered", sample_time = 1e-3, kp = 2000.0, kd = 60.0 }}
plant = '{fmu}'
[wires]
"plant.{force}" = "controller.u"
"controller.measured" = "plant.{position}"
[inputs]
reference = "controller.reference"
[outputs]
position = "plant.{position}"
force = "controller.u"
[gains]
"controller.kp" = [500.0, 8000.0]
"controller.kd" = [10.0, 150.0]
[ports]
torque = "plant.{force}"
[states]
position = "plant.{position}"
velocity = "plant.{velocity}"
command = "controller.u"
[parameters]
"controller.u_min" = -200.0
"controller.u_max" = 200.0
"""
vendor_twin = LOOP.format(
    name="vendor's axis", fmu=vendor_fmu, force="f", position="mass.s", velocity="mass.v"
)
vendor_twin += """
"plant.spring.c" = 0.0                      # its spring is taken out
"plant.spring.s_rel0" = 0.0
"plant.fixed.s0" = 0.0
"plant.mass.L" = 0.0
"""
own_twin = LOOP.format(
    name="our axis",
    fmu=MODELS / "linear_axis.fmu",
    force="port.force",
    position="true_position",
    velocity="velocity",
)
own_twin += """
"plant.kp" = 0.0                            # its own controller is switched off
"plant.kv" = 0.0
"plant.mass" = 1.0
"plant.viscous_friction" = 10.0
"""
(folder / "vendor.toml").write_text(vendor_twin, encoding="utf-8")
(folder / "own.toml").write_text(own_twin, encoding="utf-8")
# The same plant once more, exported as FMI 3.0: again one line.
(folder / "own_fmi3.toml").write_text(
    own_twin.replace("linear_axis.fmu", "linear_axis_fmi3.fmu"), encoding="utf-8"
)

# %% [markdown]
# ## The same axis three times
#
# Mass and damper are the same numbers, so the three twins move alike. Both versions of FMI give the
# same bits. The vendor's differs a little: OpenModelica exports explicit Euler steps, as long as
# the communication step.

# %%
time = np.arange(600) * 1e-3
wave = Recording(
    time=time, signals={"reference": 0.02 * np.sin(15.0 * time)}, units={"reference": "m"}
)
runs = {}
for name in ("own", "own_fmi3", "vendor"):
    with FmuTwin(folder / f"{name}.toml") as twin:
        runs[name] = twin.run({"controller.kp": 3000.0}, wave)
for signal in ("position", "force"):
    own_signal = runs["own"].signals[signal]
    apart = np.abs(runs["vendor"].signals[signal] - own_signal).max() / np.ptp(own_signal)
    print(f"{signal}: the vendor's FMU is {100.0 * apart:.2f} % of the range away from ours")
    assert apart < 0.03
    assert np.array_equal(runs["own_fmi3"].signals[signal], own_signal)

# %% [markdown]
# ## One line of the study
#
# The axis to tune (IS1) is heavier and has more friction than either twin says.

# %%
STUDY = """
method = "gmfbo_paper"
[is1]
twin = "own.toml"
parameters = { "plant.viscous_friction" = 25.0, "plant.mass" = 1.2 }
[is2]
twin = "own.toml"
[reference]
step = 0.01
at = 0.05
horizon = 0.15
[objective]
normalise = 4
[budget]
initial_is1 = 2
initial_is2 = 4
is1_runs = 3
is3_per_run = 1
"""
swapped = STUDY.replace('[is2]\ntwin = "own.toml"', '[is2]\ntwin = "vendor.toml"')
changed = [
    line for line in difflib.ndiff(STUDY.splitlines(), swapped.splitlines()) if line[0] in "+-"
]
print("\n".join(changed))

results = {}
for name, text in (("own", STUDY), ("vendor", swapped)):
    path = folder / f"with_{name}.toml"
    path.write_text(text, encoding="utf-8")
    with Tuner(Study.read(path)) as tuner:
        results[name] = tuner.run()
    found = results[name].best
    assert found is not None
    gains = ", ".join(f"{gain} = {value:.4g}" for gain, value in found.gains.items())
    print(f"IS2 = {name}.toml: {gains}, rise time {1e3 * found.metrics['rise_time']:.1f} ms")

# %% [markdown]
# ## What holds
#
# One line changed, every run of both studies ended well, and the rise times that the two twins led
# to on the axis after three runs of it are less than 10 ms apart.

# %%
assert changed == ['- twin = "own.toml"', '+ twin = "vendor.toml"']
trials = {name: Study.read(folder / f"with_{name}.toml").trials for name in results}
for made in trials.values():
    assert {trial.status for trial in made} == {"ok"}
    assert sum(trial.source == "IS1" for trial in made) == 3
    assert sum(trial.source == "IS2" for trial in made) >= 7
best = {name: result.best for name, result in results.items()}
assert best["own"] is not None
assert best["vendor"] is not None
rise_times = {name: trial.metrics["rise_time"] for name, trial in best.items() if trial}
assert abs(rise_times["own"] - rise_times["vendor"]) < 0.01  # [s]
print(
    f"one line swaps the twin: {len(trials['vendor'])} runs with the vendor's FMU, all of them ok"
)
