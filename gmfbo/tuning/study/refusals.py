"""Refuse a study that cannot be played, in one line and before its first run."""

from __future__ import annotations

from gmfbo.errors import StudyFileError, did_you_mean
from gmfbo.sources.plants.source import Source
from gmfbo.tuning.study.study_sources import StudySources
from gmfbo.tuning.study_file.gain_choice import GainChoice
from gmfbo.tuning.study_file.reference_section import ReferenceSection
from gmfbo.tuning.study_file.study_sections import StudyFile

OFF_SAMPLE = 0.01
"""Share of a sample by which a time may miss it: digits of a file."""


def refuse_unplayable(study: StudyFile, gains: GainChoice, sources: StudySources) -> None:
    """Raise for what would end a study, or play another one, after its first runs.

    Studies begun before these checks go on: call it for a new study only.

    Parameters
    ----------
    study : StudyFile
        The validated file.
    gains : GainChoice
        Tuned and held gains.
    sources : StudySources
        The FMUs among them state bounds of their parameters.

    Raises
    ------
    StudyFileError
        An integer range holds no integer, the box leaves the bounds of an FMU, the real runs end
        before the initial ones, or a sample time does not fit.
    """
    for gain in gains.space.gains:
        if gain.steps is not None and not len(gain.steps):
            raise StudyFileError(
                f"[gains] '{gain.name}': expected a range that holds a whole number, got "
                f"[{gain.low:g}, {gain.high:g}]; widen it, or leave out integer"
            )
    for source in (sources.is2, sources.is1):
        if source is not None:
            _refuse_beyond(source, gains)
    _refuse_unknown_noise(study, sources)
    budget = study.budget
    # Runs of an earlier study count as initial ones.
    least = 0 if study.earlier else budget.initial_is1
    if budget.is1_runs is not None and budget.is1_runs < least:
        raise StudyFileError(
            f"[budget] is1_runs: expected at least initial_is1 = {budget.initial_is1}, got "
            f"{budget.is1_runs}; lower initial_is1 or allow more real runs"
        )
    for reference in study.references:
        _refuse_off_sample(reference)


def _refuse_beyond(source: Source, gains: GainChoice) -> None:
    from gmfbo.sources.twin.twin import FmuTwin

    if not isinstance(source, FmuTwin):
        return
    ends = {gain.name: (gain.low, gain.high) for gain in gains.space.gains}
    ends |= {name: (value, value) for name, value in gains.fixed.items()}
    for name, (low, high) in ends.items():
        bound = source.binding.variables.get(name)
        if bound is None:
            continue
        least, most = bound.variable.minimum, bound.variable.maximum
        if (least is not None and low < least) or (most is not None and high > most):
            shown = f"[{'-inf' if least is None else f'{least:g}'}, "
            shown += f"{'inf' if most is None else f'{most:g}'}]"
            raise StudyFileError(
                f"[gains] '{name}': expected a range within {shown}, the bounds that "
                f"{source.name} states, got [{low:g}, {high:g}]; narrow the range"
            )


def _refuse_unknown_noise(study: StudyFile, sources: StudySources) -> None:
    from gmfbo.sources.twin.twin import FmuTwin

    known = sources.is1.signal_specs() if isinstance(sources.is1, FmuTwin) else {}
    for name in study.is1.noise:
        if known and name not in known:
            raise StudyFileError(f"[is1] noise: no signal '{name}'" + did_you_mean(name, known))


def _refuse_off_sample(reference: ReferenceSection) -> None:
    if reference.chosen == "file":
        return
    times = {"at": reference.at, "horizon": reference.horizon}
    if reference.chosen == "sine":
        del times["horizon"]
    if reference.chosen == "steps":
        del times["at"]
        times |= {f"times[{k}]": value for k, value in enumerate(reference.times)}
    for name, value in times.items():
        samples = value / reference.sample_time
        if samples < 1.0 - OFF_SAMPLE or abs(samples - round(samples)) > OFF_SAMPLE:
            raise StudyFileError(
                f"[reference] sample_time: expected {name} = {value:g} s to be a whole number of "
                f"samples, at least one, got {samples:.4g} samples of {reference.sample_time:g} s"
            )
