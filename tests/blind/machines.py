"""The machines of the benchmark: a true plant, and the twin file that a user would have of it."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from tests.blind.truth import KINDS

MODELS = Path(__file__).resolve().parents[2] / "models"


@dataclass(frozen=True)
class Machine:
    """One kind of axis.

    Attributes
    ----------
    name : str
        Of the kind.
    truth : mapping of str to float
        Parameters of the truth simulator, as the twin believes them.
    uncertain, gains, fixed : mapping of str to str
        Truth parameter = FMU parameter: known roughly, recorded as `#` lines, set in the twin.
    fmus : mapping of str to str
        Prefix = FMU file, or a controller's table; a single FMU has the prefix "".
    wires : mapping of str to str
        Input = output.
    signals : mapping of str to str
        `reference`, `position`, `command`: variable of the FMU. An open-loop twin is driven by
        the command and has no reference.
    ports, states : mapping of str to str
        Of the twin file.
    command_name : str
        Name of the command's column.
    units : tuple of str
        Of position, command and torque.
    strokes : mapping of str to float
        Amplitude [position] of each shape of reference.
    quantum, jitter, command_noise : float
        Encoder's resolution and white noise [position], white noise of the logged command.
    speed : float
        [position/s] Where friction's Stribeck effect ends, about.
    lines : tuple of float
        [1/position] Lowest and highest wave number of position-periodic effects.
    deflection : float
        [position] Visible elastic displacement of friction.
    is_measured : bool
        Inertia and viscous friction have been measured: the twin holds them fixed.
    """

    name: str
    truth: Mapping[str, float]
    uncertain: Mapping[str, str]
    gains: Mapping[str, str]
    fixed: Mapping[str, str]
    fmus: Mapping[str, str]
    signals: Mapping[str, str]
    ports: Mapping[str, str]
    states: Mapping[str, str]
    command_name: str
    units: tuple[str, str, str]
    strokes: Mapping[str, float]
    quantum: float
    jitter: float
    command_noise: float
    speed: float
    lines: tuple[float, float]
    deflection: float
    wires: Mapping[str, str] = field(default_factory=dict)
    is_measured: bool = False

    @property
    def free(self) -> tuple[str, ...]:
        """Parameters of the truth that the twin knows only roughly."""
        return () if self.is_measured else tuple(self.uncertain)

    @property
    def is_open_loop(self) -> bool:
        """The twin is driven by the recorded command."""
        return "reference" not in self.signals

    @property
    def is_rotary(self) -> bool:
        """Positions are angles."""
        return self.units[0] == "rad"


ROTARY = {"multisine": 0.5, "moves": 2.5, "triangle": 0.8, "chirp": 0.3, "steps": 0.18}
FULL_PORTS = ("torque", "command", "sensor")

SERVO = Machine(
    name="servo",
    truth={
        "kind": KINDS["servo_pd"],
        "inertia": 0.01,
        "viscous": 0.05,
        "torque_gain": 1.0,
        "torque_lag": 5e-4,
        "kp": 40.0,
        "kd": 0.8,
        "filter_time": 1e-3,
        "u_limit": 10.0,
    },
    uncertain={"inertia": "inertia", "viscous": "viscous"},
    gains={"kp": "kp", "kd": "kd"},
    fixed={"torque_lag": "torque_lag", "filter_time": "filter_time", "u_limit": "torque_limit"},
    fmus={"": "servo_axis.fmu"},
    signals={"reference": "reference", "position": "position", "command": "torque_command"},
    ports={"torque": "tau_load", "command": "tau_command", "sensor": "encoder_offset"},
    states={"position": "true_position", "velocity": "velocity", "command": "torque_command"},
    command_name="torque_command",
    units=("rad", "N.m", "N.m"),
    strokes=ROTARY,
    quantum=2.0 * np.pi / 65536,
    jitter=3e-5,
    command_noise=0.01,
    speed=0.1,
    lines=(4.0, 36.0),
    deflection=4e-3,
)

AXIS = Machine(
    name="axis",
    truth={
        "kind": KINDS["axis_pv"],
        "inertia": 95.1089,
        "viscous": 203.5034,
        "torque_gain": 35.1507,
        "kp": 160.18,
        "kv": 243.45,
        "u_limit": 10.0,
    },
    uncertain={"inertia": "mass", "viscous": "viscous_friction"},
    gains={"kp": "kp", "kv": "kv"},
    fixed={"torque_gain": "force_gain", "u_limit": "voltage_limit"},
    fmus={"": "linear_axis.fmu"},
    signals={"reference": "reference", "position": "position", "command": "drive_voltage"},
    ports={"torque": "port.force", "command": "port.command", "sensor": "port.sensor"},
    states={"position": "true_position", "velocity": "velocity", "command": "drive_voltage"},
    command_name="drive_voltage",
    units=("m", "V", "N"),
    strokes={"multisine": 0.02, "moves": 0.06, "triangle": 0.03, "chirp": 0.003, "steps": 8e-5},
    quantum=1e-6,
    jitter=5e-7,
    command_noise=0.02,
    speed=0.005,
    lines=(2.0 * np.pi * 80.0, 2.0 * np.pi * 500.0),
    deflection=4e-5,
)

_BENCH_TRUTH = {"inertia": 0.005, "viscous": 0.02, "torque_gain": 0.5, "u_limit": 10.0}

BENCH = replace(
    SERVO,
    name="bench",
    truth={
        **_BENCH_TRUTH,
        "kind": KINDS["pd"],
        "kp": 36.0,
        "kd": 0.84,
        "filter_time": 1e-3,
    },
    uncertain={"inertia": "inertia", "viscous": "viscous"},
    gains={},
    fixed={"torque_gain": "torque_constant"},
    fmus={"": "motor_bench.fmu"},
    signals={"position": "position", "command": "current"},
    ports={"torque": "tau_load", "command": "current"},
    states={"position": "position", "velocity": "velocity", "current": "motor_current"},
    command_name="current",
    units=("rad", "A", "N.m"),
)


def _wired(kind: str, truth: Mapping[str, float], gains: Mapping[str, str]) -> Machine:
    """The bench under one of the project's own controllers."""
    weight = ", derivative_weight = 1.0" if truth.get("derivative_weight") else ""
    table = (
        f'{{ kind = "{kind}", sample_time = 1e-3, filter_time = {truth["filter_time"]:g}{weight}, '
        f"u_min = -10.0, u_max = 10.0"
        + (f", anti_windup_gain = {truth['anti_windup']:g}" if "anti_windup" in truth else "")
        + " }"
    )
    return replace(
        BENCH,
        name=f"wires_{kind}",
        truth={**_BENCH_TRUTH, **truth},
        uncertain={"inertia": "plant.inertia", "viscous": "plant.viscous"},
        gains={key: f"controller.{name}" for key, name in gains.items()},
        fixed={"torque_gain": "plant.torque_constant"},
        fmus={"controller": table, "plant": "motor_bench.fmu"},
        wires={"plant.current": "controller.u", "controller.measured": "plant.position"},
        signals={
            "reference": "controller.reference",
            "position": "plant.position",
            "command": "controller.u",
        },
        ports={
            "torque": "plant.tau_load",
            "command": "plant.current",
            "sensor": "controller.measured",
        },
        states={
            "position": "plant.position",
            "velocity": "plant.velocity",
            "command": "controller.u",
        },
        command_name="current_command",
    )


WIRES_PID = _wired(
    "pid",
    {
        "kind": KINDS["pid"],
        "kp": 36.0,
        "kd": 0.84,
        "ki": 150.0,
        "filter_time": 1e-3,
        "anti_windup": 20.0,
    },
    {"kp": "kp", "kd": "kd", "ki": "ki"},
)
WIRES_CASCADE = _wired(
    "cascade_p_pi",
    {
        "kind": KINDS["cascade_p_pi"],
        "kp": 25.0,
        "kv": 1.5,
        "ki": 40.0,
        "filter_time": 5e-4,
        "anti_windup": 20.0,
    },
    {"kp": "kp", "kv": "kv", "ki": "ki"},
)
WIRES_PD = _wired(
    "pd_filtered",
    {
        "kind": KINDS["pd"],
        "kp": 36.0,
        "kd": 0.84,
        "filter_time": 1e-3,
        "derivative_weight": 1.0,
    },
    {"kp": "kp", "kd": "kd"},
)

MACHINES = {
    "servo": SERVO,
    "servo_torque": replace(
        SERVO, name="servo_torque", ports={"torque": "tau_load"}, strokes=ROTARY
    ),
    "servo_none": replace(SERVO, name="servo_none", ports={}),
    "axis": AXIS,
    "bench": BENCH,
    "wires_pid": WIRES_PID,
    "wires_cascade_p_pi": WIRES_CASCADE,
    "wires_pd_filtered": WIRES_PD,
    "servo_measured": replace(SERVO, name="servo_measured", is_measured=True),
    "axis_measured": replace(AXIS, name="axis_measured", is_measured=True),
    "wires_measured": replace(WIRES_PID, name="wires_measured", is_measured=True),
    "bench_measured": replace(BENCH, name="bench_measured", is_measured=True),
}


@dataclass(frozen=True)
class Knowledge:
    """What the user of the twin knows of a case, right or wrong.

    Attributes
    ----------
    values : mapping of str to float
        Nominal values of the truth's parameters.
    logged : str
        What the twin file says of the command column; empty where it says nothing.
    uncertain_scale : float
        Of the command column; 0 where the twin file says nothing.
    """

    values: Mapping[str, float]
    logged: str = ""
    uncertain_scale: float = 0.0


def variation(machine: Machine, rng: np.random.Generator) -> dict[str, float]:
    """Nominal parameters of one such machine: another inertia and friction, gains to match."""
    inertia, speed = rng.uniform(0.7, 1.4), rng.uniform(0.85, 1.15)
    values = dict(machine.truth)
    values["inertia"] *= inertia
    values["viscous"] *= rng.uniform(0.5, 1.5)
    if (
        "kv" in values and "cascade" not in machine.name
    ):  # kv has the place of a damping: mass times bandwidth
        values["kv"] *= inertia * speed
        values["kp"] *= speed
    elif "cascade" in machine.name:
        values["kv"] *= inertia * speed
        values["ki"] *= inertia * speed
        values["kp"] *= speed
    else:
        values["kp"] *= inertia * speed**2
        values["kd"] *= inertia * speed
        values["ki"] = values.get("ki", 0.0) * inertia * speed**2
    return {name: float(f"{value:.4g}") for name, value in values.items()}


def twin_file(machine: Machine, knowledge: Knowledge, folder: Path) -> str:
    """Text of the twin file of a case that lies in `folder`."""
    known = knowledge.values
    position, command, torque = machine.units
    lines = [f'name = "{machine.name.replace("_", " ")}"']
    if "" in machine.fmus:
        lines += [f'fmu = "{_relative(machine.fmus[""], folder)}"', "step = 1e-3"]
    else:
        lines += ["step = 1e-3", "", "[fmus]"]
        for prefix, entry in machine.fmus.items():
            shown = entry if entry.startswith("{") else f'"{_relative(entry, folder)}"'
            lines.append(f"{prefix} = {shown}")
        lines += ["", "[wires]", *_pairs(machine.wires)]
    name, column = machine.command_name, f'variable = "{machine.signals["command"]}"'
    if knowledge.uncertain_scale:
        column += f", uncertain_scale = {knowledge.uncertain_scale:g}"
    if knowledge.logged:
        column += f', logged = "{knowledge.logged}"'
    if machine.is_open_loop:
        lines += ["", "[inputs]", f'{name} = "{machine.signals["command"]}"  # [{command}]']
        lines += ["", "[outputs]"]
    else:
        lines += ["", "[inputs]", f'reference = "{machine.signals["reference"]}"  # [{position}]']
        lines += ["", "[outputs]", f"{name} = {{ {column} }}  # [{command}]"]
    lines += [f'position = "{machine.signals["position"]}"  # [{position}]']
    lines += ["", "[parameters]"]
    for names in (machine.fixed, machine.uncertain, machine.gains):
        lines += [f'"{fmu}" = {known[own]!r}' for own, fmu in names.items()]
    if machine.is_open_loop:
        lines += ["", "[initial]", '"initial_position" = "position"']
    if machine.gains:
        lines += ["", "[gains]"]
        lines += [
            f'"{fmu}" = [{0.25 * known[own]:.6g}, {2.0 * known[own]:.6g}]'
            for own, fmu in machine.gains.items()
            if known[own] > 0.0
        ]
    lines += ["", "[uncertain]"] if machine.free else []
    lines += [
        f'"{machine.uncertain[own]}" = [{0.5 * known[own]:.6g}, {2.0 * known[own]:.6g}]'
        for own in machine.free
    ]
    if machine.ports:
        lines += ["", f"[ports]  # torque in {torque}", *_pairs(machine.ports)]
    lines += ["", "[states]", *_pairs(machine.states)]
    lines += ["", "[roles]", f'inertia = "{machine.uncertain["inertia"]}"', ""]
    return "\n".join(lines)


def _pairs(table: Mapping[str, str]) -> list[str]:
    return [
        f'{key if key.isidentifier() else chr(34) + key + chr(34)} = "{value}"'
        for key, value in table.items()
    ]


def _relative(fmu: str, folder: Path) -> str:
    return Path(os.path.relpath(MODELS / fmu, folder)).as_posix()
