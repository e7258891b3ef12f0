"""Metrics, experiment and safety of a study file, checked against gains and sources."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import StudyFileError, did_you_mean
from gmfbo.objective.own_metrics import OwnMetrics
from gmfbo.tuning.experiment.experiment_series import ExperimentSeries
from gmfbo.tuning.query.method import Method, PublishedMethod
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.study.study_sources import StudySources
from gmfbo.tuning.study_file.gain_choice import GainChoice
from gmfbo.tuning.study_file.safety_section import SafetySection
from gmfbo.tuning.study_file.study_sections import GainRange

if TYPE_CHECKING:
    from gmfbo.recordings.store.memory_store import TrialStore


def own_metrics(study: Study) -> OwnMetrics | None:
    """Load the user's own metrics; None where the file names none.

    Raises
    ------
    InputError
        The function cannot be loaded.
    """
    label = study.file.objective.metrics
    if label is None:
        return None
    return OwnMetrics.load(label, study.origin, study.file.own_metrics)


def experiment_of(study: Study, unit: str, own: OwnMetrics | None) -> ExperimentSeries:
    """References that a study plays, and the metrics of their responses.

    Parameters
    ----------
    study : Study
        Its file names the references.
    unit : str
        SI unit of the references.
    own : OwnMetrics or None
        Metrics by a function of the user.

    Raises
    ------
    RecordingError
        A file cannot be read, or does not hold exactly one step.
    """
    return ExperimentSeries.from_sections(
        study.file.references,
        study.file.objective.signal,
        folder=study.origin,
        unit=unit,
        own=own,
    )


def ranked(study: Study, store: TrialStore, method: Method) -> bool:
    """Whether runs are ranked before their cost counts; otherwise a failed run has a price.

    Parameters
    ----------
    study : Study
        Its file may ask for the published price.
    store : TrialStore
        Says by which version of the objective the study was begun.
    method : Method
        May price a failed run itself, as its publication does.
    """
    published = study.file.objective.as_published or isinstance(method, PublishedMethod)
    return not published and study.objective_version(store) >= 2


def in_force(study: Mapping[str, GainRange], gains: GainChoice) -> NDArray[np.float64]:
    """Gains in force today as a point of the unit cube, shape (1, d); (0, d) without.

    Parameters
    ----------
    study : mapping of str to GainRange
        Part `[gains]` of the study file.
    gains : GainChoice
        Tuned and held gains.

    Raises
    ------
    StudyFileError
        Only some of the tuned gains say what is in force.
    """
    names = gains.space.names
    now = {name: one.now for name, one in study.items() if one.now is not None and name in names}
    if not now:
        return np.empty((0, len(names)))
    for name in names:
        if name not in now:
            raise StudyFileError(
                f"[gains] '{name}': expected now = VALUE, the value in force today, as for "
                f"'{next(iter(now))}'; give it for each tuned gain or for none"
            )
    return gains.space.to_unit(gains.space.point({name: now[name] for name in names}))[None, :]


def known_safe(section: SafetySection, gains: GainChoice) -> NDArray[np.float64]:
    """Known-safe gains as points of the unit cube, shape (n, d).

    Parameters
    ----------
    section : SafetySection
        With `start`.
    gains : GainChoice
        Tuned and held gains.

    Raises
    ------
    StudyFileError
        A point lacks a value for a tuned gain, or lies outside the box.
    """
    names = gains.space.names
    for values in section.start:
        if len(values) != len(names):
            raise StudyFileError(
                f"[safety] start: expected one value for each of {', '.join(names)}, "
                f"got {list(values)}"
            )
        for gain, value in zip(gains.space.gains, values, strict=True):
            if not gain.low <= value <= gain.high:
                raise StudyFileError(
                    f"[safety] start: expected '{gain.name}' within [{gain.low:g}, "
                    f"{gain.high:g}], got {value:g}; widen [gains]"
                )
    points = np.reshape(np.array(section.start, dtype=float), (-1, len(names)))
    return gains.space.to_unit(points)


def check_signals(section: SafetySection, sources: StudySources) -> None:
    """Raise for an envelope of signals that an FMU plant does not output.

    Parameters
    ----------
    section : SafetySection
        Signals of the envelope.
    sources : StudySources
        With IS1; the signals of a plant that is no FMU are unknown beforehand.

    Raises
    ------
    StudyFileError
        A signal is unknown.
    """
    from gmfbo.sources.twin.twin import FmuTwin

    if not isinstance(sources.is1, FmuTwin):
        return
    envelope, known = section.envelope, sources.is1.signal_specs()
    for name in sorted(
        {*envelope.ranges, *(envelope.condition.names if envelope.condition else ())}
    ):
        if name not in known:
            raise StudyFileError(f"[safety]: no signal '{name}'" + did_you_mean(name, known))
