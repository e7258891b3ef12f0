"""One case of a draw: its twin file and recordings, and the answer apart."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np

from tests.blind.cases import Answer, make_case
from tests.blind.draw.nulls import VARIANTS, draft_null
from tests.blind.draw.plan import DrawnCase
from tests.blind.draw.rigs import record_with
from tests.blind.gains import OWED, case_gain
from tests.blind.machines import Knowledge, twin_file

TRIES = 6
"""Times that a case is drawn again whose effect the oracle cannot see."""

SIZES = ((15.0, "below"), (60.0, "around"), (250.0, "above"), (1e3, "clear"), (1e4, "large"))
"""Oracle gains below which a case has this size class; `huge` above."""


def make_drawn(case: DrawnCase, seed: int, index: int, folder: Path, models: Path) -> Answer:
    """Write all that the diagnosis sees of a case, and answer what it hides.

    Parameters
    ----------
    case : DrawnCase
        What kind of case.
    seed, index : int
        Of the draw, and of the case in it; all that is random follows from them.
    folder : Path
        Of this case.
    models : Path
        For FMUs that the draw builds.
    """
    if VARIANTS.get(case.family):
        answer = _make_null(case, seed, index, _emptied(folder), models)
        tries = 1
    else:
        answer, tries = _make_known(case, seed, index, folder)
    told = {
        "stratum": case.stratum,
        "family": case.family,
        "variant": case.variant,
        "size": size_class(case_gain(answer.__dict__)) if answer.effects else "",
        "tries": tries,
    }
    return replace(answer, details={**answer.details, **told})


def size_class(gain: float) -> str:
    """Class of an oracle gain, by `SIZES`."""
    return next((name for most, name in SIZES if gain < most), "huge")


def _make_known(case: DrawnCase, seed: int, index: int, folder: Path) -> tuple[Answer, int]:
    """A case of the blind benchmark; one whose effect must show is drawn until it does."""
    must_show = case.stratum in ("owed", "outside", "pair")
    for attempt in range(TRIES):
        answer = make_case(case.plan, seed, index + attempt * 100_000, _emptied(folder))
        if not must_show or case_gain(answer.__dict__) > OWED:
            return answer, attempt + 1
    return answer, TRIES


def _make_null(case: DrawnCase, seed: int, index: int, folder: Path, models: Path) -> Answer:
    rng = np.random.default_rng([seed, index + 1])
    null = draft_null(VARIANTS[case.family][case.variant], case.plan.machine, models, rng)
    machine, draft = null.machine, null.draft
    for k, experiment in enumerate(null.experiments):
        values = {**draft.true, **experiment.gains}
        text = record_with(null.rig, machine, values, experiment, draft.logger, rng)
        (folder / f"rec{k}.csv").write_text(text, encoding="utf-8")
    knowledge = Knowledge(draft.believed, draft.logged, draft.uncertain_scale)
    (folder / "twin.toml").write_text(twin_file(machine, knowledge, folder), encoding="utf-8")
    return Answer(
        case=folder.name,
        kind="null",
        machine=machine.name,
        ports=sorted(machine.ports),
        within_reach=True,
        effects=[],
        target_gain=[],
        oracle_gain=0.0,
        nearest=[],
        parameters={
            machine.uncertain[own]: {"true": draft.true[own], "nominal": draft.believed[own]}
            for own in machine.free
        },
        details={
            **draft.notes,
            **draft.logger.told(),
            "rig": null.rig.told(),
            **null.told,
            "shapes": [one.shape for one in null.experiments],
        },
    )


def _emptied(folder: Path) -> Path:
    """The folder, without what an earlier try left in it."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder
