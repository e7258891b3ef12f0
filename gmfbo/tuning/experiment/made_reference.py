"""The reference that a study file describes, as a recording."""

from __future__ import annotations

from pathlib import Path

from gmfbo.recordings.recording import Recording
from gmfbo.recordings.reference import (
    recorded_reference,
    sine_reference,
    step_reference,
    steps_reference,
    with_disturbance,
)
from gmfbo.tuning.study_file.reference_section import ReferenceSection


def made_reference(section: ReferenceSection, folder: Path, unit: str) -> Recording:
    """Make or read a reference; a disturbance becomes its second signal.

    Parameters
    ----------
    section : ReferenceSection
        The part `[reference]`.
    folder : Path
        Folder to which a path in the section is relative.
    unit : str
        SI unit of the reference; a file may state its own.

    Raises
    ------
    RecordingError
        The file cannot be read, or lacks the column.
    InputError
        The section describes no reference.
    """
    made = _followed(section, folder, unit)
    push = section.disturbance
    return made if push is None else with_disturbance(made, push.port, push.step, push.at)


def _followed(section: ReferenceSection, folder: Path, unit: str) -> Recording:
    signal, start, sample_time = section.signal, section.start, section.sample_time
    match section.chosen:
        case "file":
            recording = Recording.read(folder / (section.file or ""))
            return recorded_reference(recording, section.column or signal, signal=signal)
        case "steps":
            return steps_reference(
                section.times,
                section.levels,
                horizon=section.horizon,
                sample_time=sample_time,
                start=start,
                signal=signal,
                unit=unit,
            )
        case "sine":
            return sine_reference(
                section.amplitude,
                section.frequency,
                section.cycles,
                at=section.at,
                sample_time=sample_time,
                start=start,
                signal=signal,
                unit=unit,
            )
        case _:
            return step_reference(
                section.step,
                at=section.at,
                horizon=section.horizon,
                sample_time=sample_time,
                start=start,
                signal=signal,
                unit=unit,
            )
