"""One case: a plan becomes a true plant, recordings of it, a twin file, and an answer."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from tests.blind.hidden import EFFECTS, NEAREST, OUTSIDE, Changes, Hidden, Setting
from tests.blind.machines import MACHINES, Knowledge, Machine, twin_file, variation
from tests.blind.oracle import Experiment, Oracle
from tests.blind.plan import Plan
from tests.blind.recording import Logger, record
from tests.blind.references import SHAPES
from tests.blind.truth import Diverged, TrueRun, Vector, simulate
from tests.blind.windows import windows_of

Rng = np.random.Generator

WEAK_GAIN, STRONG_GAIN = (4.0, 60.0), (60.0, 1e6)
"""Oracle gains that the sizes of single effects are drawn for, log-uniform; a third are weak."""

CLEAR_GAIN = {"pair": (500.0, 5e4), "outside": (1e3, 1e6)}
"""The same for those that ask another question than that of the limit."""


@dataclass(frozen=True)
class Answer:
    """What a case hides; written as JSON.

    Attributes
    ----------
    case, kind, machine : str
        Number, kind of the plan, machine.
    ports : list of str
        That the twin has.
    within_reach : bool
        Whether the twin has the ports for what is hidden.
    effects : list of dict
        `name`, `changes` of the true plant, `size`, `signal_path` (those that are right),
        `states`, `windows` as [recording, t0, t1], `oracle_gain` of this effect.
    oracle_gain : float
        Of all hidden effects over parameters alone; 0 for nulls, decoys included.
    nearest : list of str
        Names that come nearest to what is outside the catalogue.
    parameters : dict
        True and nominal value by FMU parameter.
    details : dict
        Stresses or decoy, logger's convention, clock skew, shapes of the references.
    """

    case: str
    kind: str
    machine: str
    ports: list[str]
    within_reach: bool
    effects: list[dict[str, Any]]
    oracle_gain: float
    nearest: list[str]
    parameters: dict[str, dict[str, float]]
    details: dict[str, Any]

    def text(self) -> str:
        """JSON, the same for the same answer."""
        return json.dumps(self.__dict__, indent=1, sort_keys=True) + "\n"


@dataclass
class _Draft:
    """A case in the making: what the plant is, what the user believes, what the logger does."""

    true: dict[str, float]
    believed: dict[str, float]
    logger: Logger
    logged: str = ""
    uncertain_scale: float = 0.0
    notes: dict[str, Any] = field(default_factory=dict)


def make_case(plan: Plan, seed: int, index: int, folder: Path) -> Answer:
    """Write twin.toml and the recordings of a case, and answer what it hides.

    Parameters
    ----------
    plan : Plan
        What kind of case.
    seed, index : int
        Of the benchmark, and of the case in it; all that is random follows from them.
    folder : Path
        Of this case; what is in it is all that the diagnosis sees.
    """
    rng = np.random.default_rng([seed, index + 1])
    machine = MACHINES[plan.machine]
    draft = _draft(plan, machine, rng)
    experiments = _experiments(machine, draft.true, rng)
    oracle = Oracle(
        machine, draft.true, experiments, int(rng.integers(2**31)), draft.uncertain_scale
    )
    clean = oracle.runs({})
    setting = _setting(machine, draft.true, clean)
    _apply_decoy(plan, setting, draft, rng)
    changes, effects, gain = _hide(plan, setting, oracle, rng)
    folder.mkdir(parents=True, exist_ok=True)
    names = [f"rec{k}.csv" for k in range(len(experiments))]
    for name, experiment in zip(names, experiments, strict=True):
        values = {**draft.true, **experiment.gains, **changes}
        text = record(machine, values, experiment, draft.logger, rng)
        (folder / name).write_text(text, encoding="utf-8")
    knowledge = Knowledge(draft.believed, draft.logged, draft.uncertain_scale)
    (folder / "twin.toml").write_text(twin_file(machine, knowledge, folder), encoding="utf-8")
    shown = oracle.runs(changes)
    for effect in effects:
        kind = {**EFFECTS, **OUTSIDE}[effect["name"]].windows
        effect["windows"] = [
            [name, start, end]
            for name, run in zip(names, shown, strict=True)
            for start, end in windows_of(kind, run, machine.speed)
        ]
    return Answer(
        case=folder.name,
        kind=plan.kind,
        machine=plan.machine,
        ports=sorted(machine.ports),
        within_reach=plan.is_within_reach,
        effects=effects,
        oracle_gain=gain,
        nearest=sorted(frozenset().union(*(NEAREST.get(n, frozenset()) for n in plan.effects))),
        parameters={
            fmu: {"true": draft.true[own], "nominal": draft.believed[own]}
            for own, fmu in machine.uncertain.items()
        },
        details={
            **draft.notes,
            **draft.logger.told(),
            "shapes": [one.shape for one in experiments],
        },
    )


def _draft(plan: Plan, machine: Machine, rng: Rng) -> _Draft:
    """True and believed parameters, a logger, and the stresses of the plan."""
    believed = variation(machine, rng)
    true = dict(believed)
    true["inertia"] *= 1.0 + rng.choice([-1.0, 1.0]) * rng.uniform(0.05, 0.15)
    true["viscous"] *= 1.0 + rng.choice([-1.0, 1.0]) * rng.uniform(0.05, 0.3)
    convention = "new" if rng.random() < 0.3 or machine.is_open_loop else "held"
    draft = _Draft(true, believed, Logger(convention))
    if rng.random() < 0.4 and not machine.is_open_loop:
        draft.logged = convention
    if rng.random() < 0.3 and not machine.is_open_loop:
        draft.uncertain_scale = 0.05
    draft.notes["stress"] = list(plan.details)
    for stress in plan.details if plan.kind == "stressed_null" else ():
        _STRESSES[stress](draft, rng)
    return draft


def _stress_lag(draft: _Draft, rng: Rng) -> None:
    lag = draft.true.get("torque_lag", 0.0)
    draft.true["torque_lag"] = lag * rng.uniform(0.8, 1.3) if lag else rng.uniform(5e-5, 1.5e-4)


def _stress_scale(draft: _Draft, rng: Rng) -> None:
    draft.logger = draft.logger.changed(scale=1.0 + rng.choice([-0.03, 0.03]))
    draft.uncertain_scale = 0.05 if rng.random() < 0.5 else 0.0


def _stress_convention(draft: _Draft, rng: Rng) -> None:
    draft.logger, draft.logged = draft.logger.changed(convention="new"), ""


def _stress_clock(draft: _Draft, rng: Rng) -> None:
    draft.logger = draft.logger.changed(skew=rng.uniform(100e-6, 200e-6) * rng.choice([-1.0, 1.0]))


def _stress_colour(draft: _Draft, rng: Rng) -> None:
    draft.logger = draft.logger.changed(colour=0.95)


def _stress_gain(draft: _Draft, rng: Rng) -> None:
    draft.true["drive_gain_error"] = rng.uniform(0.01, 0.02) * rng.choice([-1.0, 1.0])


_STRESSES: Mapping[str, Callable[[_Draft, Rng], None]] = {
    "torque_lag": _stress_lag,
    "column_scale": _stress_scale,
    "logger_new": _stress_convention,
    "clock_skew": _stress_clock,
    "coloured_noise": _stress_colour,
    "drive_gain": _stress_gain,
}


def _apply_decoy(plan: Plan, setting: Setting, draft: _Draft, rng: Rng) -> None:
    """Something that is there but leaves nothing to name."""
    name, true, believed = (*plan.details, "")[0], draft.true, draft.believed
    if plan.kind != "decoy":
        return
    if name == "drive_gain":
        true["drive_gain_error"] = -rng.uniform(0.04, 0.12)
    elif name == "shared_limit":
        true["u_limit"] = believed["u_limit"] = float(f"{0.6 * setting.peak_command:.4g}")
    elif name == "limit_out_of_reach":
        true["drive_limit"] = 1.4 * setting.peak_command
    elif name == "rate_out_of_reach":
        true["drive_rate"] = 200.0 * setting.peak_slew
    elif name == "sensor_zero":
        true["sensor_zero"] = rng.uniform(5.0, 20.0) * setting.machine.quantum
    elif name == "more_inertia":
        true["load_inertia_extra"] = rng.uniform(0.15, 0.3) * believed["inertia"]
    elif name == "shared_lag":
        lag = 2e-3 if "torque_lag" in setting.machine.fixed else 0.0
        true["torque_lag"] = believed["torque_lag"] = lag
    elif name == "sensor_scale":
        true["sensor_scale"] = rng.uniform(0.01, 0.03)


def _experiments(machine: Machine, true: Mapping[str, float], rng: Rng) -> list[Experiment]:
    """Four to six recordings; a third of them at other gains."""
    shapes = ["multisine", "moves", "triangle", "chirp" if rng.random() < 0.6 else "steps"]
    shapes += list(rng.permutation(["steps", "moves"]))[
        : int(rng.choice([0, 1, 2], p=[0.7, 0.2, 0.1]))
    ]
    experiments = []
    for shape in shapes:
        gains = {
            own: float(
                f"{true[own] * (rng.uniform(0.75, 1.25) if rng.random() < 0.33 else 1.0):.4g}"
            )
            for own in machine.gains
        }
        rows = int(rng.integers(2500, 4001))
        reference = SHAPES[shape](rng, rows) * machine.strokes[shape] * rng.uniform(0.8, 1.2)
        experiments.append(Experiment(shape, _within_limit(reference, {**true, **gains}), gains))
    return experiments


def _within_limit(reference: Vector, values: Mapping[str, float]) -> Vector:
    """The reference, reduced until its command stays within three quarters of the limit."""
    while np.max(np.abs(simulate(values, reference).new)) > 0.75 * values["u_limit"]:
        reference = 0.8 * reference
    return reference


def _setting(machine: Machine, true: Mapping[str, float], runs: list[TrueRun]) -> Setting:
    commands = [run.new for run in runs]
    peak_command = float(max(np.max(np.abs(u)) for u in commands))
    peak_speed = float(max(np.max(np.abs(run.velocity)) for run in runs))
    return Setting(
        machine=machine,
        values=true,
        peak_command=peak_command,
        rms_command=float(np.sqrt(np.mean(np.concatenate(commands) ** 2))),
        peak_slew=float(max(np.max(np.abs(np.diff(u))) for u in commands) / 1e-3),
        peak_speed=peak_speed,
        travel=float(max(np.max(np.abs(run.position)) for run in runs)),
        peak_mix=float(
            max(
                np.max(np.abs(run.new) / peak_command + np.abs(run.velocity) / peak_speed)
                for run in runs
            )
        ),
    )


def _hide(
    plan: Plan, setting: Setting, oracle: Oracle, rng: Rng
) -> tuple[Changes, list[dict[str, Any]], float]:
    """Changes of the plant by all hidden effects, what the answer says of each, total gain."""
    changes: Changes = {}
    effects, gains = [], []
    weak = rng.random() < 1.0 / 3.0
    low, high = CLEAR_GAIN.get(plan.kind, WEAK_GAIN if weak else STRONG_GAIN)
    for name in plan.effects:
        hidden = {**EFFECTS, **OUTSIDE}[name]
        target = float(np.exp(rng.uniform(np.log(low), np.log(high))))
        shaped = hidden.make(setting, rng)
        size = size_for_gain(hidden, shaped, setting, oracle, target)
        own = shaped(size)
        changes.update(own)
        alone = oracle.gain(own)
        gains.append(alone)
        effects.append(
            {
                "name": name,
                "size": size,
                "changes": own,
                "signal_path": list(hidden.paths),
                "states": list(hidden.states),
                "oracle_gain": alone,
            }
        )
    if not effects:
        return {}, [], 0.0
    return changes, effects, gains[0] if len(gains) == 1 else oracle.gain(changes)


def size_for_gain(
    hidden: Hidden,
    shaped: Callable[[float], Changes],
    setting: Setting,
    oracle: Oracle,
    target: float,
) -> float:
    """Size at which the oracle gains about `target`, within what is plausible; by bisection.

    A loop that no longer holds, and swings to twice what was asked, is not plausible.
    """
    low, high = np.log(hidden.low(setting)), np.log(hidden.high(setting))
    reach = [2.0 * np.max(np.abs(run.position)) for run in oracle.runs({})]
    for _ in range(10):
        middle = 0.5 * (low + high)
        try:
            runs = oracle.runs(shaped(float(np.exp(middle))))
            bounded = all(
                np.max(np.abs(run.position)) < most for run, most in zip(runs, reach, strict=True)
            )
            weaker = bounded and oracle.quick_gain(runs) < target
        except Diverged:
            weaker = False
        if weaker:
            low = middle
        else:
            high = middle
    return float(f"{np.exp(low):.4g}")
