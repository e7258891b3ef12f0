"""Values of FMU parameters for one run, by priority, within the FMU's bounds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import InputError, RecordingError, did_you_mean
from gmfbo.recordings.recording import Recording
from gmfbo.sources.binding.binding import Binding
from gmfbo.sources.fmu_file.job import ArrayElement, Setting, TextSetting


@dataclass(frozen=True, eq=False)
class RunParameters:
    """Parameters set before a run, and parameters that change during it.

    Attributes
    ----------
    settings : tuple of Setting
        Set before initialisation.
    in_force : mapping of str to float
        Values [FMU's unit] that this run set over the twin file's, by name.
    schedules : mapping of str to ndarray, shape (n,)
        Parameters that change, at the recording's times.
    texts : tuple of TextSetting
        Texts set before initialisation.
    """

    settings: tuple[Setting, ...]
    in_force: Mapping[str, float]
    schedules: Mapping[str, NDArray[np.float64]]
    texts: tuple[TextSetting, ...] = ()


def run_parameters(
    binding: Binding,
    recording: Recording,
    override: Mapping[str, float],
    gains: Mapping[str, float],
    texts: Mapping[str, str] | None = None,
) -> RunParameters:
    """Choose each parameter's value: twin file < recording < [initial] < override < gains.

    Parameters
    ----------
    binding : Binding
        The twin.
    recording : Recording
        Its parameters and schedules count.
    override : mapping of str to float
        Given for the twin or the run [FMU's unit].
    gains : mapping of str to float
        Given for the run [FMU's unit].
    texts : mapping of str to str, optional
        Parameters of type String, over the twin file's.

    Raises
    ------
    InputError
        A name is unknown, or a value outside the FMU's bounds.
    RecordingError
        A name or value of the recording is wrong, or a parameter changes that is not tunable.
    """
    label = recording.name or "recording"
    for name in (*recording.parameters, *recording.schedules):
        if name not in binding.parameters:
            raise RecordingError(
                f"{label}: no FMU parameter '{name}'" + did_you_mean(name, binding.parameters)
            )
    explicit = {**override, **gains}
    _check_names(binding, explicit)
    first, changing = _split_schedules(binding, recording, explicit)
    in_force = {**recording.parameters, **first, **explicit}
    values = {
        **binding.settings,
        **recording.parameters,
        **first,
        **_initial_values(binding, recording),
        **explicit,
    }
    for name, value in values.items():
        binding.variables[name].check_value(float(value))
    values = _with_whole_arrays(binding, values)
    settings = tuple(binding.variables[n].setting(float(v)) for n, v in values.items())
    words = {**binding.words.texts, **(texts or {})}
    told = tuple(binding.variables[name].text_setting(word) for name, word in words.items())
    return RunParameters(settings, in_force, changing, told)


def _with_whole_arrays(binding: Binding, values: Mapping[str, float]) -> dict[str, float]:
    """Values, and the nominal ones of the other elements of arrays: FMI sets whole arrays."""
    set_arrays = {
        (bound.fmu, element.reference)
        for bound in (binding.variables[name] for name in values)
        if (element := ArrayElement.of(bound.variable.reference)) is not None
    }
    whole = dict(values)
    for name, bound in binding.variables.items() if set_arrays else ():
        element = ArrayElement.of(bound.variable.reference)
        if element is not None and (bound.fmu, element.reference) in set_arrays:
            whole.setdefault(name, binding.nominal(name))
    return whole


def check_parameters(binding: Binding, override: Mapping[str, float]) -> None:
    """Raise for an invalid parameter of the twin file or the override, before any run.

    Parameters
    ----------
    binding : Binding
        The twin.
    override : mapping of str to float
        Given for the twin [FMU's unit].

    Raises
    ------
    InputError
        A name is unknown, or a value outside the FMU's bounds.
    """
    _check_names(binding, override)
    for name, value in {**binding.settings, **override}.items():
        binding.variables[name].check_value(float(value))


def _check_names(binding: Binding, given: Mapping[str, float]) -> None:
    for name in given:
        if name not in binding.parameters:
            raise InputError(
                f"{binding.file.name}: no FMU parameter '{name}'"
                + did_you_mean(name, binding.parameters)
            )


def _split_schedules(
    binding: Binding, recording: Recording, explicit: Mapping[str, float]
) -> tuple[dict[str, float], dict[str, NDArray[np.float64]]]:
    """First value of each schedule, and the schedules that change after it."""
    first, changing = {}, {}
    for name, column in recording.schedules.items():
        if name in explicit:
            continue  # a value given for this run holds throughout
        sampled = np.flatnonzero(~np.isnan(column))
        if sampled.size == 0:
            continue
        first[name] = float(column[sampled[0]])
        changes = np.flatnonzero(np.diff(column[sampled]))
        if changes.size == 0:
            continue
        variable = binding.variables[name].variable
        if not variable.tunable:
            time = float(recording.time[sampled[changes[0] + 1]])
            raise RecordingError(
                f"{recording.name or 'recording'}: parameter '{name}' changes at t = {time:g} s, "
                f"but the FMU declares it {variable.variability}; expected one value, or a "
                "parameter that is tunable"
            )
        for value in np.unique(column[sampled]):
            binding.variables[name].check_value(float(value))
        changing[name] = column
    return first, changing


def starts_as_recorded(binding: Binding, recording: Recording) -> bool:
    """Whether [initial] states the recording's start, so that nothing has to settle.

    Parameters
    ----------
    binding : Binding
        The twin.
    recording : Recording
        A bare reference holds no measured signal, and [initial] then does not apply.
    """
    initial = binding.file.initial
    return bool(initial) and all(
        not isinstance(source, str) or source == "fit" or source in recording.signals
        for source in initial.values()
    )


def _initial_values(binding: Binding, recording: Recording) -> dict[str, float]:
    """Parameters of [initial], from the recording's first row where a signal is named [SI].

    The nominal value stays for an entry "fit", and where the recording lacks the signal.
    """
    values = {}
    for name, source in binding.file.initial.items():
        if not isinstance(source, str):
            values[name] = float(source)
        elif source != "fit" and source in recording.signals:
            column = recording.signal(source)
            sampled = np.flatnonzero(~np.isnan(column))
            if sampled.size == 0:
                raise RecordingError(
                    f"{recording.name or 'recording'}: [initial] needs the first value of "
                    f"'{source}', all are blank"
                )
            variable = binding.variables[name].variable
            values[name] = (float(column[sampled[0]]) - variable.si_zero) / variable.to_si
    return values
