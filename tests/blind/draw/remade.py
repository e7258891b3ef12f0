"""A drawn case again from its answer: the true plant, what was asked of it, and its recordings.

All that is random follows from the seed and the number of the case, but for the sizes of hidden
effects: those are searched for with an oracle, and stand in the answer.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from tests.blind.draft import NEEDS_REVERSALS, apply_decoy, draft_of
from tests.blind.draw.nulls import VARIANTS, NullCase
from tests.blind.draw.plan import REGISTERED, DrawnCase, draw_plan
from tests.blind.draw.rich import RICH
from tests.blind.draw.rigs import Rig, logged_with
from tests.blind.experiments import experiments_of, setting_of
from tests.blind.hidden import EFFECTS, Changes, Rng, Setting
from tests.blind.machines import MACHINES, Machine
from tests.blind.oracle import Experiment, Oracle
from tests.blind.outside import LAWS_OUTSIDE
from tests.blind.plan import Plan
from tests.blind.recording import Logger, record
from tests.blind.sizing import target_gain
from tests.blind.truth import Vector

Columns = list[Vector]
"""Position and command of each recording, shape (rows, 2) each."""


@dataclass(frozen=True)
class Remade:
    """All that was drawn of one case.

    Attributes
    ----------
    machine : Machine
        With the twin's parameters as the case has them.
    values : mapping of str to float
        The true plant without what is hidden.
    changes : mapping of str to float
        Of the plant by all that is hidden.
    experiments : sequence of Experiment
        References and gains.
    logger : Logger
        What wrote the recordings.
    rig : Rig
        What stood between the plant and the file.
    oracle : Oracle
        The one that sized what is hidden.
    rng : Generator
        As it was before the first recording.
    """

    machine: Machine
    values: Mapping[str, float]
    changes: Changes
    experiments: Sequence[Experiment]
    logger: Logger
    rig: Rig
    oracle: Oracle
    rng: Rng

    @property
    def plant(self) -> dict[str, float]:
        """The true plant with all that is hidden."""
        return {**self.values, **self.changes}

    def recordings(self) -> Columns:
        """What the files of a case hold that is no null of the draw; can be called once."""
        shown = []
        for one in self.experiments:
            values = {**self.plant, **one.gains}
            text = record(self.machine, values, one, self.logger, self.rng)
            rows = [line.split(",")[-2:] for line in text.splitlines() if line[0] in "-.0123456789"]
            shown.append(np.array(rows, dtype=float))
        return shown

    def clean(self, values: Mapping[str, float], chosen: Sequence[int] | None = None) -> Columns:
        """Columns without noise, in closed loop from the references.

        Parameters
        ----------
        values : mapping of str to float
            Of the plant.
        chosen : sequence of int, optional
            Recordings; all without it.
        """
        silent = replace(self.machine, jitter=0.0, quantum=0.0, command_noise=0.0)
        faults = {"position_noise": 0.0, "position_count": 0.0, "command_count": 0.0}
        rig = self.rig.changed(**faults, jitter=0.0, load=0.0, loop_is_clean=True)
        wanted = range(len(self.experiments)) if chosen is None else chosen
        rng = np.random.default_rng(0)  # draws what is multiplied by zero
        return [
            np.column_stack(
                logged_with(rig, silent, {**values, **one.gains}, one, self.logger, rng)
            )
            for one in (self.experiments[k] for k in wanted)
        ]


def of_count(count: float) -> float:
    """Standard deviation of what rounding to a count does, in its unit."""
    return count / float(np.sqrt(12.0))


@cache
def _plan(seed: int) -> tuple[DrawnCase, ...]:
    return tuple(draw_plan(REGISTERED, seed))


def remade(answer: Mapping[str, Any], seed: int) -> Remade:
    """Draw a case of a registered draw again.

    Parameters
    ----------
    answer : mapping
        Of the case.
    seed : int
        Of the draw.
    """
    index = int(answer["case"])
    case = _plan(seed)[index]
    if VARIANTS.get(case.family):
        return _null(case, answer, np.random.default_rng([seed, index + 1]))
    index += (answer["details"]["tries"] - 1) * 100_000
    return known(case.plan, answer, np.random.default_rng([seed, index + 1]))


def known(plan: Plan, answer: Mapping[str, Any], rng: Rng) -> Remade:
    """A case of the blind benchmark, as `tests.blind.cases.make_case` draws it.

    Parameters
    ----------
    plan : Plan
        Of the case.
    answer : mapping
        For the sizes of what is hidden.
    rng : Generator
        At its beginning.
    """
    machine = MACHINES[plan.machine]
    draft = draft_of(plan, machine, rng)
    one_way = plan.kind == "decoy" and plan.details[0] in NEEDS_REVERSALS
    experiments = experiments_of(machine, draft.true, rng, one_way=one_way)
    oracle = Oracle(
        machine, draft.true, experiments, int(rng.integers(2**31)), draft.uncertain_scale
    )
    setting, changes = setting_of(machine, draft.true, oracle.clean), Changes()
    if plan.kind == "decoy":
        apply_decoy(plan.details[0], setting, draft, rng)
        changes = draft.decoy
    for name, effect in zip(plan.effects, answer["effects"], strict=plan.kind != "decoy"):
        _pass_over(plan, name, setting, rng)
        changes.update(effect["changes"])
    return Remade(machine, draft.true, changes, experiments, draft.logger, Rig(), oracle, rng)


def _pass_over(plan: Plan, name: str, setting: Setting, rng: Rng) -> None:
    """Draw what an effect was sized for and its shape, to leave the generator where they did."""
    target_gain(plan.kind, plan.band, rng)
    {**EFFECTS, **LAWS_OUTSIDE}[name].make(setting, rng)


def _null(case: DrawnCase, answer: Mapping[str, Any], rng: Rng) -> Remade:
    """A null of the draw; MuJoCo's, which is certified, is played by the plant that it equals."""
    variant = VARIANTS[case.family][case.variant]
    machine = RICH if case.plan.machine == "rich" else MACHINES[case.plan.machine]
    draft = draft_of(Plan("null", machine.name, details=variant.details), machine, rng)
    experiments = experiments_of(machine, draft.true, rng)
    null = NullCase(machine, draft, experiments, Rig(), models=Path())
    if case.family != "simulator":
        variant.change(null, rng, variant)
    oracle = Oracle(machine, draft.true, experiments, 0, draft.uncertain_scale)
    return Remade(null.machine, draft.true, {}, experiments, draft.logger, null.rig, oracle, rng)
