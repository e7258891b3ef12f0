"""Valid twin files, study files and CSV recordings to begin with."""

from __future__ import annotations

from functools import cache

import numpy as np

from gmfbo.recordings import Recording, Trajectory
from gmfbo.recordings.writing.csv_text import csv_text
from gmfbo.sources.fmu_file.models import models_folder

_RICH_TWIN = """
name = "AX7 servo axis"
step = 1e-3
warmup = 0.5
dialect = "auto"
[fmus]
controller = { kind = "pd_filtered", sample_time = 1e-3 }
plant = "drive_plant.fmu"
[wires]
"plant.tau" = "controller.u"
"controller.measured" = "plant.phi"
[inputs]
reference = { variable = "controller.reference", column = "soll", interpolation = "linear" }
[outputs]
position = { variable = "plant.phi", column = "counts", scale = 1.5e-3, offset = "fit" }
torque_command = { variable = "controller.u", scale = "mot.kt", logged = "held" }
speed = { variable = "plant.w", shift_range = [-2e-3, 2e-3] }
[parameters]
"plant.tauMax" = 60.0
"plant.on" = true
[gains]
"controller.kp" = [30.0, 200.0]
"controller.kd" = { low = 2.0, high = 10.0, scale = "log" }
"controller.n" = { low = 2, high = 10, integer = true }
"controller.fixed" = 3.0
[uncertain]
"plant.J" = [0.06, 0.24]
[ports]
torque = "plant.tau"
[states]
velocity = "plant.w"
[roles]
inertia = "plant.J"
[initial]
"plant.phi0" = "position"
"plant.w0" = "fit"
"plant.a0" = 1.5
[columns]
reference = "soll"
time = { column = "t", unit = "ms" }
"""

_RICH_STUDY = """
name = "axis 3"
seed = 3
method = "gmfbo"
out = "axis3.study"
[is1]
twin = "plant.toml"
parameters = { "map.noise" = 0.5, "map.seed" = "seed" }
change = { after_runs = 4, parameters = { "friction.scale" = 2.0 } }
[is2]
twin = "twin.toml"
[gains]
"ctl.Kp" = [30.0, 200.0]
"ctl.Kd" = { low = 1.0, high = 9.0, scale = "log" }
"ctl.n" = { low = 1, high = 9, integer = true }
"ctl.F" = 4.0
[[reference]]
step = 1.0
at = 0.1
horizon = 1.0
weight = 2.0
[[reference]]
file = "ref.csv"
[objective]
signal = "position"
weights = { overshoot = 0.02, transient_time = 0.20, mine = 1 }
metrics = "mine.py:function"
[objective.normalise]
mean = { overshoot = 1.0, transient_time = 2.0, mine = 3 }
std = { overshoot = 1.0, transient_time = 0.5, mine = 1 }
[constraints]
overshoot = 5.0
[safety]
torque_command = [-60.0, 60.0]
start = [[90.0, 4.0]]
expression = "abs(position - reference) < 0.5 and torque_command < 60"
[drift]
watch = true
repeat_every = 5
[budget]
initial_is1 = 2
initial_is2 = 10
iterations = 20
is3_per_run = 4
"""

_PLAIN_STUDY = """
[is1]
command = ["python", "bench.py", "{gains}"]
time_limit = 10
retries = 1
[is2]
twin = "twin.toml"
[reference]
step = 1
[objective]
normalise = 10
[budget]
is1_runs = 22
"""

_LOGGER_CSV = (
    "# ctl.Kp = 90.0\n# use = 0.001:0.004\n# start_time = 2026-01-02T03:04:05\n"
    "time [ms],reference [rad],position [deg],speed [rpm],note\n"
    + "".join(f"{k},1.0,{k * 0.5},{'' if k % 2 else k},ok\n" for k in range(12)),
    "\ufeffsep=;\nDrive log\nZeit;Referenz;position;speed\ns;rad;rad;rad/s\n"
    + "".join(f"{k},5;1,25;1.234,5;{k}\n" for k in range(8)),
    "t\treference\tposition\r\n" + "".join(f"{k}e-3\t1\t{k}\r\n" for k in range(8)),
    "time,reference,position\n"
    + "".join(f"2026-01-02T03:04:05.{k:03d}Z,1,{k}\n" for k in range(8)),
    'time,"reference, [rad]","position ""x"""\n' + "".join(f"{k},1,2\n" for k in range(8)),
    "Name,export\nFile,x\nStarttime of export,132538000000000000\nName,reference,position\n"
    "SymbolName,GVL.ref,GVL.pos\nUnit,(None),mm (Length)\n"
    + "".join(f"{k},1,{k}\n" for k in range(8)),
    "# time reference position\n" + "".join(f"{k}e-3 1  {k}\n" for k in range(8)),
    "% run 1\n% time,reference\n% s,rad\n" + "".join(f"{k},1\n" for k in range(8)),
    "X,reference,Start,Increment,\nSequence,Volt,-1.0e-1,1.0e-3\n"
    + "".join(f"{k},{k}.5,\n" for k in range(8)),
    "reference(V),t0 = -2e-3, tInc = 1e-3,\n" + "".join(f"{k}.5,,\n" for k in range(8)),
    "XInc:,1.0E-03\nXOrg:,-2.0E-03\nData:,\n" + "".join(f"{k}\n" for k in range(8)),
    "Record Length,8,Points,-0.1,0.5,\nSample Interval,1,ms,-0.099,0.6,\nSource,CH1,,-0.098,0.7,\n"
    + "".join(f",,,{k * 1e-3 - 0.097:.3f},{k}.5,\n" for k in range(8)),
    "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t.\nX_Columns\tMulti\n"
    "Date\t2016/08/11\nTime\t14:37:48.2\n***End_of_Header***\t\n\t\nChannels\t2\nSamples\t8\t8\n"
    "X0\t0\t0\nDelta_X\t1e-3\t1e-3\n***End_of_Header***\nX_Value\treference\tX_Value\tposition\n"
    + "".join(f"{k}e-3\t1\t{k}e-3\t{k}\n" for k in range(8)),
    "Date;Time;reference;reference\n"
    + "".join(f"02.01.2026;11:59:5{k}.5 PM;1;2\n" for k in range(8)),
    "time,reference,position\n" + "".join(f"{k // 2},{k % 2 or ''},{k}\n" for k in range(12)),
)


@cache
def twin_files() -> list[bytes]:
    """Those of the models, and one that uses every key."""
    shipped = sorted(models_folder().glob("*.toml"))
    return [path.read_bytes() for path in shipped] + [_RICH_TWIN.encode()]


@cache
def study_files() -> list[bytes]:
    """One that uses every section, a small one."""
    return [_RICH_STUDY.encode(), _PLAIN_STUDY.encode()]


@cache
def csv_files() -> list[bytes]:
    """Our own, and those of several loggers."""
    time = 1e-3 * np.arange(12, dtype=np.float64)
    signals = {"reference": np.ones(12), "position": np.sin(time), "speed": np.full(12, np.nan)}
    units = {"reference": "rad", "position": "rad", "speed": "rad/s"}
    plain = Recording(time, signals, units, "r", {"ctl.Kp": 90.0}, {"mech.J": np.ones(12)})
    run = Trajectory(time, signals, units, use=(0.001, 0.009), status="diverged", stopped_at=0.01)
    ours = [csv_text(recording, "0.1.0").encode() for recording in (plain, run)]
    return [*ours, *(text.encode() for text in _LOGGER_CSV)]
