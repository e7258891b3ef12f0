"""Diagnose the physics that a calibrated twin lacks, and build the twin with it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from gmfbo.errors import GmfboError
from gmfbo.recordings.recording import Recording
from gmfbo.retuning.unknowns import Scalar
from gmfbo.sources.twin.twin import FmuTwin

_FACTOR, _SHARE = 4.0, 1.0
"""Range of an identified parameter about its value: a factor, or a share where it may be zero."""


@dataclass(frozen=True, eq=False)
class Completion:
    """A twin completed by the missing physics.

    Attributes
    ----------
    twin : FmuTwin
        The augmented twin; its FMU lies in the folder that was given.
    scalars : tuple of Scalar
        Parameters of the physics, at their identified values.
    names : tuple of str
        Of the effects.
    parameters : mapping of str to float
        Uncertain parameters [FMU's unit] refitted together with the physics.
    sentence : str
        The verdict in plain words.
    named : tuple of mapping
        `name`, `statement` and `probability` of each effect, as the diagnosis says them.
    """

    twin: FmuTwin
    scalars: tuple[Scalar, ...]
    names: tuple[str, ...]
    parameters: Mapping[str, float]
    sentence: str
    named: tuple[Mapping[str, Any], ...] = ()


def complete(
    twin: FmuTwin,
    tables: Mapping[str, float],
    recordings: Sequence[Recording],
    folder: Path,
    *,
    seed: int,
) -> Completion | None:
    """Diagnose a twin, and export it with the missing physics.

    Parameters
    ----------
    twin : FmuTwin
        As given.
    tables : mapping of str to float
        Parameters [FMU's unit] of its tables, as estimated.
    recordings : sequence of Recording
        Real runs.
    folder : Path
        For the augmented FMU; made if it is needed.
    seed : int
        Of the diagnosis.

    Returns
    -------
    Completion or None
        None where no effect is named, or where this twin cannot be exported.
    """
    from gmfbo.diagnosis.engine import diagnose

    given = {**twin.parameters, **tables}
    try:
        with FmuTwin(twin.path, parameters=given, driven_ports=twin.driven_ports) as calibrated:
            found = diagnose(calibrated, recordings, seed=seed, jobs=1)
            if found.augmentation is None or not found.augmentation.physics:
                return None
            folder.mkdir(parents=True, exist_ok=True)
            exported = found.augmentation.export(folder)
            parameters = dict(found.augmentation.parameters)
            physics = found.augmentation.physics
    except GmfboError:
        # A study must not end because its twin cannot be explained.
        return None
    augmented = FmuTwin(exported.twin_file, driven_ports=twin.driven_ports)
    scalars = tuple(_about(augmented, f"physics.{one.name}", one.value) for one in physics)
    names = tuple(effect.name for effect in found.effects)
    named = tuple(
        {"name": one.name, "statement": one.statement, "probability": one.set_probability}
        for one in found.effects
    )
    # The study plays runs of its own: no reference is proposed.
    sentence = replace(found, next_experiment=None).sentence
    return Completion(augmented, scalars, names, parameters, sentence, named)


def _about(twin: FmuTwin, name: str, value: float) -> Scalar:
    """A parameter with the uncertainty of a diagnosis from a few short runs."""
    variable = twin.binding.variables[name].variable
    low = -float("inf") if variable.minimum is None else variable.minimum
    high = float("inf") if variable.maximum is None else variable.maximum
    if value > 0.0 and low >= 0.0:
        return Scalar(name, value, max(value / _FACTOR, low), min(value * _FACTOR, high))
    reach = _SHARE * (abs(value) or 1.0)
    return Scalar(name, value, max(value - reach, low), min(value + reach, high))
