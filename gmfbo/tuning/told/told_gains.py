"""Find the gains of a told recording, and check them against the request."""

from __future__ import annotations

from collections.abc import Mapping

from gmfbo.errors import InputError, RecordingError, did_you_mean
from gmfbo.recordings.recording import Recording
from gmfbo.space import same_gain
from gmfbo.tuning.query.request import TrialRequest
from gmfbo.tuning.study_file.gain_choice import GainChoice


def told_gains(
    request: TrialRequest,
    recording: Recording,
    choice: GainChoice,
    *,
    given: Mapping[str, float] | None = None,
    anyway: bool = False,
) -> dict[str, float]:
    """Gains of a recording: as given, else as recorded, else as requested.

    Parameters
    ----------
    request : TrialRequest
        The request.
    recording : Recording
        The told recording; its parameters hold the gains in force.
    choice : GainChoice
        Ranges of the gains, and the values of those that are held.
    given : mapping of str to float, optional
        Gains in force, which override the recording's.
    anyway : bool
        Accept a recording at other gains than requested.

    Raises
    ------
    InputError
        A given gain is unknown, or its value is one that the study could not ask for.
    RecordingError
        The recording was made at other gains.
    """
    given = dict(given or {})
    for name in given:
        if name not in request.gains:
            raise InputError(f"no gain '{name}'" + did_you_mean(name, request.gains))
    says = {n: recording.parameters[n] for n in request.gains if n in recording.parameters}
    used = {**request.gains, **says, **given}
    differing = [name for name in used if not same_gain(used[name], request.gains[name])]
    if not differing:
        return dict(request.gains)
    name = differing[0]
    label = recording.name or "recording"
    if not (given or anyway):
        raise RecordingError(
            f"{label}: made with {name} = {used[name]:g}, but trial {request.number} asks for "
            f"{request.gains[name]:g}; record again at the gains asked for, or take it as it is "
            "(--anyway)"
        )
    for name in differing:
        if name in choice.fixed:
            raise InputError(
                f"{label}: made with {name} = {used[name]:g}, which the study holds at "
                f"{choice.fixed[name]:g}; record again with that value"
            )
    choice.check_fixed({name: used[name] for name in choice.space.names}, label=label)
    return used


def chosen_request(
    waiting: Mapping[int, TrialRequest],
    trial: TrialRequest | int | None,
    stated: Mapping[str, float],
) -> TrialRequest:
    """The request that a recording answers.

    Parameters
    ----------
    waiting : mapping of int to TrialRequest
        Requests that are waited for, by trial number.
    trial : TrialRequest, int or None
        Request or its number; None where it is to be found.
    stated : mapping of str to float
        Gains that the recording, or the user, states.

    Raises
    ------
    InputError
        It is not waited for, or several are and the stated gains do not tell which.
    """
    numbers = ", ".join(str(number) for number in waiting)
    if trial is None and len(waiting) > 1:
        fitting = [
            request
            for request in waiting.values()
            if any(name in stated for name in request.gains)
            and all(same_gain(stated.get(n, v), v) for n, v in request.gains.items())
        ]
        if len(fitting) != 1:
            raise InputError(
                f"trials {numbers} are waited for, and the gains of the recording tell no one of "
                "them; say which by --trial NUMBER"
            )
        return fitting[0]
    number = next(iter(waiting), 0) if trial is None else trial
    number = number if isinstance(number, int) else number.number
    if number not in waiting:
        verb = "is" if len(waiting) == 1 else "are"
        wanted = f"trial{'' if verb == 'is' else 's'} {numbers} {verb}" if waiting else "none is"
        raise InputError(
            f"trial {number} is not waited for: {wanted}; ask for the next gains first"
        )
    return waiting[number]
