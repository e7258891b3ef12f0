"""One case: a plan becomes a true plant, recordings of it, a twin file, and an answer."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tests.blind.draft import NEEDS_REVERSALS, Draft, apply_decoy, draft_of
from tests.blind.experiments import experiments_of, setting_of
from tests.blind.hidden import EFFECTS, Changes, Rng, Setting
from tests.blind.machines import MACHINES, Knowledge, Machine, twin_file
from tests.blind.oracle import Oracle
from tests.blind.outside import LAWS_OUTSIDE, NEAREST
from tests.blind.plan import Plan
from tests.blind.recording import record
from tests.blind.sizing import size_for_gain, target_gain
from tests.blind.true_values import true_values
from tests.blind.windows import windows_of

_ALL = {**EFFECTS, **LAWS_OUTSIDE}


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
        `states`, `windows` as [recording, t0, t1], `values` in a diagnosis's words,
        `oracle_gain` of this effect alone, `added_gain` over the other ones.
    target_gain : list of float
        What the sizes were drawn for.
    oracle_gain : float
        Of all hidden effects over parameters alone; 0 for nulls, of what a decoy leaves.
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
    target_gain: list[float]
    oracle_gain: float
    nearest: list[str]
    parameters: dict[str, dict[str, float]]
    details: dict[str, Any]

    def text(self) -> str:
        """JSON, the same for the same answer."""
        return json.dumps(self.__dict__, indent=1, sort_keys=True) + "\n"


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
    draft = draft_of(plan, machine, rng)
    one_way = plan.kind == "decoy" and plan.details[0] in NEEDS_REVERSALS
    experiments = experiments_of(machine, draft.true, rng, one_way=one_way)
    seed_of_noise = int(rng.integers(2**31))
    oracle = Oracle(machine, draft.true, experiments, seed_of_noise, draft.uncertain_scale)
    setting = setting_of(machine, draft.true, oracle.clean)
    if plan.kind == "decoy":
        apply_decoy(plan.details[0], setting, draft, rng)
        hidden = _Hidden(draft.decoy, _effects_of_decoy(plan, draft), 0.0, [])
    else:
        hidden = _hide(plan, setting, oracle, rng)
    folder.mkdir(parents=True, exist_ok=True)
    names = [f"rec{k}.csv" for k in range(len(experiments))]
    for name, experiment in zip(names, experiments, strict=True):
        values = {**draft.true, **experiment.gains, **hidden.changes}
        text = record(machine, values, experiment, draft.logger, rng)
        (folder / name).write_text(text, encoding="utf-8")
    knowledge = Knowledge(draft.believed, draft.logged, draft.uncertain_scale)
    (folder / "twin.toml").write_text(twin_file(machine, knowledge, folder), encoding="utf-8")
    _add_windows(hidden, oracle, names)
    plant = {**draft.true, **hidden.changes}
    return Answer(
        case=folder.name,
        kind=plan.kind,
        machine=plan.machine,
        ports=sorted(machine.ports),
        within_reach=plan.is_within_reach,
        effects=hidden.effects,
        target_gain=hidden.targets,
        oracle_gain=hidden.gain,
        nearest=sorted(frozenset().union(*(NEAREST.get(n, frozenset()) for n in plan.effects))),
        parameters={
            machine.uncertain[own]: {"true": plant[own], "nominal": draft.believed[own]}
            for own in machine.free
        },
        details={
            **draft.notes,
            **draft.logger.told(),
            **_wrong_fixed(machine, draft),
            "band": plan.band,
            "shapes": [one.shape for one in experiments],
        },
    )


def _wrong_fixed(machine: Machine, draft: Draft) -> dict[str, Any]:
    """A parameter that the twin holds fixed at another value than the plant's: no false name."""
    for own, name in machine.fixed.items():
        true, believed = draft.true.get(own), draft.believed.get(own)
        if true is not None and believed is not None and true != believed:
            return {"fixed": {"name": name, "true": true, "believed": believed}}
    return {}


@dataclass
class _Hidden:
    """What is hidden: all changes of the plant, what the answer says, gain, gains asked for."""

    changes: Changes
    effects: list[dict[str, Any]]
    gain: float
    targets: list[float]


def _effects_of_decoy(plan: Plan, draft: Draft) -> list[dict[str, Any]]:
    """An effect that the motion hides: nothing is owed, but its name would be no wrong one."""
    name = NEEDS_REVERSALS.get(plan.details[0])
    return [] if name is None else [_described(name, draft.decoy, draft.true, 0.0)]


def _described(name: str, own: Changes, true: Mapping[str, float], size: float) -> dict[str, Any]:
    return {
        "name": name,
        "size": size,
        "changes": own,
        "values": true_values(name, own, true),
        "signal_path": list(_ALL[name].paths),
        "states": list(_ALL[name].states),
    }


def _hide(plan: Plan, setting: Setting, oracle: Oracle, rng: Rng) -> _Hidden:
    """Size each effect by its own gain, then put all in."""
    hidden = _Hidden({}, [], 0.0, [])
    for name in plan.effects:
        law, target = _ALL[name], target_gain(plan.kind, plan.band, rng)
        shaped = law.make(setting, rng)
        size = size_for_gain(law, shaped, setting, oracle, target)
        own = shaped(size)
        hidden.changes.update(own)
        hidden.targets.append(target)
        hidden.effects.append(_described(name, own, setting.values, size))
    for effect in hidden.effects:
        effect["oracle_gain"] = effect["added_gain"] = oracle.gain(effect["changes"])
    if len(hidden.effects) == 1:
        hidden.gain = hidden.effects[0]["oracle_gain"]
    elif hidden.effects:
        _gains_together(hidden, oracle)
    return hidden


def _gains_together(hidden: _Hidden, oracle: Oracle) -> None:
    """What each effect adds to the others."""
    means = oracle.means(hidden.changes)
    hidden.gain = oracle.gain(hidden.changes, means=means)
    for effect in hidden.effects:
        others: Changes = {}
        for other in hidden.effects:
            if other is not effect:
                others.update(other["changes"])
        effect["added_gain"] = oracle.gain(hidden.changes, known=others, means=means)


def _add_windows(hidden: _Hidden, oracle: Oracle, names: Sequence[str]) -> None:
    if not hidden.effects:
        return
    shown = oracle.runs(hidden.changes)
    for effect in hidden.effects:
        effect["windows"] = [
            [name, start, end]
            for name, run in zip(names, shown, strict=True)
            for start, end in windows_of(_ALL[effect["name"]].windows, run, oracle.machine.speed)
        ]
