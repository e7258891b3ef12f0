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
# # Your own rig
#
# The real axis (IS1) need not be an FMU. It may be a **program** that gmfbo starts, a **person** at
# a bench, a **folder** of recordings, or a **Python function**. Here each of them tunes the same
# drive with the same twin. The drive has four times the viscous friction that its twin knows of.

# %%
from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

from gmfbo import (
    FmuTwin,
    Recording,
    Study,
    Trajectory,
    Tuner,
    models_folder,
    step_reference,
    write_recording,
)
from gmfbo.sources.plants.failed_run import failed_run

MODELS = models_folder()
WORN = {"friction.viscous": 2.0}  # [N m s/rad]
folder = Path(tempfile.mkdtemp(prefix="gmfbo-rig-"))

STUDY = """
method = "bo_ei"
[is1]
{is1}
[is2]
twin = '{twin}'
parameters = {{ "friction.viscous" = 0.5 }}
[gains]                                # in force now: the first run is there
"ctl.Kp" = {{ low = 30.0, high = 200.0, now = 60.0 }}
"ctl.Kd" = {{ low = 2.0, high = 10.0, now = 6.0 }}
[reference]
step = 1.0
at = 0.1
horizon = 0.5
[objective]
normalise = 4
[budget]
initial_is2 = 4
is1_runs = 3
"""


def study_of(name: str, is1: str) -> Study:
    """Write a study file."""
    path = folder / f"{name}.toml"
    path.write_text(STUDY.format(is1=is1, twin=MODELS / "drive_twin.toml"), encoding="utf-8")
    return Study.read(path)


# %% [markdown]
# ## A program
#
# It is called with `--set NAME=VALUE` for each gain, `--request FILE.json` (the same as a file),
# `--reference FILE.csv` and `--out FILE.csv`. It leaves the recording there and ends with status 0.
# Any other status is a failed run: it is priced, its last line on standard error is kept, and the
# study goes on. This one drives an FMU; yours talks to the drive.

# %%
BENCH = f"""
import json, sys
from gmfbo import FmuTwin, Recording, write_recording

request = json.load(open(sys.argv[sys.argv.index("--request") + 1], encoding="utf-8"))
if request["gains"]["ctl.Kp"] > 150.0:
    sys.exit("the drive tripped")
with FmuTwin({str(MODELS / "drive_twin.toml")!r}, parameters={WORN!r}) as drive:
    run = drive.run(request["gains"], Recording.read(request["reference"]))
write_recording(run, request["out"])
"""
(folder / "bench.py").write_text(BENCH, encoding="utf-8")

by_program = study_of(
    "program", f"command = ['{sys.executable}', 'bench.py']\ntime_limit = 60.0\nretries = 1"
)
with Tuner(by_program) as tuner:
    program_result = tuner.run()
for trial in by_program.trials:
    if trial.source == "IS1":
        gains = ", ".join(f"{name} = {value:.4g}" for name, value in trial.gains.items())
        print(f"{gains}: {trial.status}, objective {trial.objective:.3f}")


# %% [markdown]
# ## A Python function
#
# It takes gains and reference, and returns a `Recording`, the path of one, or arrays by name. What
# it raises is a failed run.


# %%
def worn_drive(gains: Mapping[str, float], reference: Recording) -> Trajectory:
    """Answer of the drive."""
    if gains["ctl.Kp"] > 150.0:
        raise RuntimeError("the drive tripped")
    with FmuTwin(MODELS / "drive_twin.toml", parameters=WORN) as drive:
        return drive.run(gains, reference)


by_function = study_of("function", "ask_tell = true")
with Tuner(by_function, plant=worn_drive) as tuner:
    function_result = tuner.run()

# %% [markdown]
# ## A person at a bench
#
# `gmfbo ask` prints the next gains and writes the reference to play, with the gains in its lines;
# `gmfbo tell` takes the recording. Here the person is a loop. Asking again before telling prints
# the same gains.


# %%
def gmfbo(*words: str | Path) -> str:
    """Run the program and return what it prints, without the colours that a kernel asks for."""
    command = [sys.executable, "-m", "gmfbo", *map(str, words)]
    plain = {name: value for name, value in os.environ.items() if name != "FORCE_COLOR"}
    done = subprocess.run(
        command, check=True, capture_output=True, text=True, cwd=folder, env=plain
    )
    return done.stdout


by_hand = study_of("bench", "ask_tell = true")
asked = gmfbo("ask", "bench.toml")
print(asked)
assert gmfbo("ask", "bench.toml") == asked
for run in range(3):
    if run:
        gmfbo("ask", "bench.toml")
    wanted = Recording.read(folder / "bench.study" / "next.csv")
    gains_wanted = {name: wanted.parameters[name] for name in ("ctl.Kp", "ctl.Kd")}
    try:
        write_recording(worn_drive(gains_wanted, wanted), folder / "measured.csv")
        print(gmfbo("tell", "bench.toml", "measured.csv").splitlines()[0])
    except RuntimeError as error:
        print(gmfbo("tell", "bench.toml", "--failed", str(error)).splitlines()[0])

# %% [markdown]
# The same from Python, where the loop is yours:

# %%
by_script = study_of("script", "ask_tell = true")
with Tuner(by_script) as tuner:
    while (request := tuner.ask()) is not None:
        reference = tuner.experiment.reference
        try:
            tuner.tell(request, worn_drive(request.gains, reference))
        except RuntimeError as error:
            tuner.tell(request, failed_run(reference, str(error)))

# %% [markdown]
# ## A folder of recordings
#
# What was measured beforehand is replayed. Each recording names its gains in `# NAME = VALUE`
# lines, or the file `gains.csv` does (`recording,ctl.Kp,ctl.Kd`). A proposal goes to the nearest
# recorded gains that are left; nothing is interpolated.

# %%
(folder / "grid").mkdir()
step = step_reference(1.0, at=0.1, horizon=0.5)
for kp in (40.0, 70.0, 100.0, 130.0):
    for kd in (3.0, 6.0, 9.0):
        measured = worn_drive({"ctl.Kp": kp, "ctl.Kd": kd}, step)
        write_recording(measured, folder / "grid" / f"kp{kp:.0f}_kd{kd:.0f}.csv")

by_recordings = study_of("grid", 'recorded = "grid/"')
with Tuner(by_recordings) as tuner:
    grid_result = tuner.run()
assert grid_result.best is not None
print("best of the recordings asked for:", dict(grid_result.best.gains))

# %% [markdown]
# ## What holds for all of them
#
# The program, the function, the person and the script ran the same drive: the same seed asked for
# the same gains and brought the same costs. The recordings were asked for at their own gains.

# %%
outcomes = [
    [(dict(t.gains), t.status, round(t.objective, 6)) for t in study.trials if t.source == "IS1"]
    for study in (by_program, by_function, by_hand, by_script)
]
assert len(outcomes[0]) == 3
assert all(outcome == outcomes[0] for outcome in outcomes)
for trial in by_recordings.trials:
    if trial.source == "IS1":
        assert trial.gains["ctl.Kp"] in (40.0, 70.0, 100.0, 130.0)
        assert trial.gains["ctl.Kd"] in (3.0, 6.0, 9.0)
assert program_result.best is not None
assert function_result.best is not None
print("four ways to run one drive, the same study:", len(outcomes[0]), "real runs each")
