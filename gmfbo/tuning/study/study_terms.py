"""Metrics, experiment and safety of a study file, checked against gains and sources."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import InputError, RecordingError, StudyFileError, did_you_mean
from gmfbo.objective.limits import Limits
from gmfbo.objective.margins import MARGINS
from gmfbo.objective.metrics import METRICS
from gmfbo.objective.own_metrics import OwnMetrics
from gmfbo.objective.tracking import COMMAND_METRICS, TRACKING_METRICS
from gmfbo.tuning.experiment.experiment_series import ExperimentSeries
from gmfbo.tuning.experiment.loop_margins import MarginMeter
from gmfbo.tuning.experiment.scoring_terms import ScoringTerms
from gmfbo.tuning.query.method import CorrectionOptions, Method, PublishedMethod
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.study.study_sources import StudySources
from gmfbo.tuning.study_file.gain_choice import GainChoice
from gmfbo.tuning.study_file.safety_section import SafetySection
from gmfbo.tuning.study_file.study_sections import GainRange, StudyFile

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


def experiment_of(study: Study, sources: StudySources, own: OwnMetrics | None) -> ExperimentSeries:
    """References that a study plays, and the metrics of their responses.

    Parameters
    ----------
    study : Study
        Its file names the references.
    sources : StudySources
        With the unit of the references, and the outputs that are command and velocity.
    own : OwnMetrics or None
        Metrics by a function of the user.

    Raises
    ------
    RecordingError
        A file cannot be read, or ends before the horizon.
    StudyFileError
        A section describes no reference, or a weighted or limited metric cannot be computed.
    """
    objective = study.file.objective
    terms = ScoringTerms(
        band=objective.band,
        filter_s=objective.filter,
        command=objective.command or sources.command,
        velocity=sources.velocity,
    )
    try:
        series = ExperimentSeries.from_sections(
            study.file.references,
            objective.signal,
            folder=study.origin,
            unit=sources.reference_unit,
            own=own,
            terms=terms,
        )
    except RecordingError:
        raise
    except InputError as error:
        raise StudyFileError(f"[reference]: {error}") from None
    _check_computable(study.file, series)
    return series


def _check_computable(file: StudyFile, series: ExperimentSeries) -> None:
    """Raise for a weighted or limited metric that these references or signals do not give."""
    weighted = [name for name, weight in file.objective.weights.items() if weight > 0.0]
    places = [("[objective] weights", weighted), ("[constraints]", list(file.constraints))]
    for place, names in places:
        for name in names:
            if name in METRICS and name not in series.metric_names:
                raise StudyFileError(
                    f"{place}: '{name}' needs a reference with a step, and none has one; weigh "
                    f"{', '.join(TRACKING_METRICS)} or one of the command instead"
                )
            if name in COMMAND_METRICS and series.terms.command is None and series.own is None:
                raise StudyFileError(
                    f"{place}: '{name}' needs the command, which [states] of the twin file does "
                    'not name among its [outputs]; say it by [objective] command = "SIGNAL"'
                )


def margin_meter(
    study: Study, sources: StudySources, experiment: ExperimentSeries
) -> MarginMeter | None:
    """What measures margins of the loop on the twin; None unless one is limited.

    Parameters
    ----------
    study : Study
        Its [constraints] limit margins.
    sources : StudySources
        With the twin whose command port is driven.
    experiment : ExperimentSeries
        Its first reference gives size and length of the motion.

    Raises
    ------
    StudyFileError
        The twin is no FMU, or its command is unknown.
    """
    if not Limits(study.file.constraints).of_the_twin:
        return None
    limited = next(name for name in study.file.constraints if name in MARGINS)
    if not sources.loop_twins:
        raise StudyFileError(
            f"[constraints] {limited}: needs [is2] twin = FILE, whose loop is excited"
        )
    command = experiment.terms.command
    if command is None:
        raise StudyFileError(
            f"[constraints] {limited}: needs the command, which [states] of the twin file does not "
            'name among its [outputs]; say it by [objective] command = "SIGNAL"'
        )
    fine, coarse = sources.loop_twins
    part = experiment.parts[0]
    return MarginMeter(fine, coarse, part.reference, command, part.horizon, coarse.step)


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


def twin_options(study: Study, store: TrialStore, method: Method) -> CorrectionOptions | None:
    """Options of the twin's runs around real ones; None where the method makes none.

    In studies begun before version 3 these runs are corrected, whether the method uses it or not.

    Parameters
    ----------
    study : Study
        The study.
    store : TrialStore
        Says by which version of the objective the study was begun.
    method : Method
        The method.
    """
    options = method.correction
    if options is None or not options.around_real:
        return None
    if study.objective_version(store) < 3:
        return replace(options, corrected=True)
    return options


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
        Only some tuned gains say what is in force, or one says a value that it may not take.
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
    now = {name: now[name] for name in names}
    _check_allowed(gains, now, "[gains] now")
    return gains.space.to_unit(gains.space.point(now))[None, :]


def _check_allowed(gains: GainChoice, values: Mapping[str, float], label: str) -> None:
    """Raise for values that the gains may not take; others near by would be run instead."""
    try:
        gains.check_fixed(values, label=label)
    except InputError as error:
        raise StudyFileError(f"{error}; widen [gains] or change it") from None


def starts_of(study: StudyFile, gains: GainChoice) -> NDArray[np.float64]:
    """Gains in force and other known-safe ones, which are run first, in the unit cube (n, d).

    Parameters
    ----------
    study : StudyFile
        With `[gains]` and `[safety]`.
    gains : GainChoice
        Tuned and held gains.

    Raises
    ------
    StudyFileError
        A tuned gain lacks a value, or a point lies outside the box.
    """
    return np.vstack([in_force(study.gains, gains), known_safe(study.safety, gains)])


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
        A point lacks a value for a tuned gain, lies outside the box, or has a value that a gain may
        not take.
    """
    names = gains.space.names
    for values in section.start:
        if len(values) != len(names):
            raise StudyFileError(
                f"[safety] start: expected one value for each of {', '.join(names)}, "
                f"got {list(values)}"
            )
        _check_allowed(gains, gains.space.named(values), "[safety] start")
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
