"""What to say of a worker that crashed, left or hung."""

from __future__ import annotations

import signal
from collections.abc import Sequence

from gmfbo.sources.job import Stage

_WINDOWS_FAULTS = {0xC0000005: "access violation", 0xC00000FD: "stack overflow"}
_CURES = {
    Stage.LOAD: "ask its vendor for a build for this system",
    Stage.INSTANTIATE: "check that its licence and resources are in place, or ask its vendor",
    Stage.INITIALISE: "check its parameters and initial values, or ask its vendor",
}


def crash_message(
    names: Sequence[str], stage: Stage, fmu: int, exit_code: int, time: float | None, said: str
) -> str:
    """One line on a worker that is gone.

    Parameters
    ----------
    names : sequence of str
        FMUs in order of computation.
    stage : Stage
        What the worker was busy with.
    fmu : int
        Which FMU, outside of steps.
    exit_code : int
        Negative where a signal ended it.
    time : float or None
        [s] Last communication point that was reached.
    said : str
        What it printed last.
    """
    cure = _CURES.get(stage, "try other gains or parameters, or ask its vendor")
    return (
        f"{_who(names, stage, fmu)} {_end(exit_code)} while {stage.words}{_at(stage, time)}; "
        f"{cure}{_quoted(said)}"
    )


def timeout_message(
    names: Sequence[str], stage: Stage, fmu: int, limit_s: float, time: float | None, said: str
) -> str:
    """One line on a worker that did not answer in time.

    Parameters
    ----------
    names : sequence of str
        FMUs in order of computation.
    stage : Stage
        What the worker was busy with.
    fmu : int
        Which FMU, outside of steps.
    limit_s : float
        [s] Wall-clock time that it had.
    time : float or None
        [s] Last communication point that was reached.
    said : str
        What it printed last.
    """
    return (
        f"{_who(names, stage, fmu)} did not finish within {limit_s:g} s, stopped while "
        f"{stage.words}{_at(stage, time)}; raise time_limit_s if it is slow, else it "
        f"hangs there{_quoted(said)}"
    )


def _who(names: Sequence[str], stage: Stage, fmu: int) -> str:
    if stage == Stage.STEP and len(names) > 1:
        return "one of " + ", ".join(f"'{name}'" for name in names)
    return f"'{names[fmu]}'"


def _end(exit_code: int) -> str:
    if exit_code in _WINDOWS_FAULTS:
        return f"crashed ({_WINDOWS_FAULTS[exit_code]})"
    if exit_code >= 0:
        return f"ended its process with exit code {exit_code}"
    try:
        return f"crashed ({signal.Signals(-exit_code).name})"
    except ValueError:
        return f"crashed (signal {-exit_code})"


def _at(stage: Stage, time: float | None) -> str:
    return f" after t = {time:g} s" if stage == Stage.STEP and time is not None else ""


def _quoted(said: str) -> str:
    return f"; it printed last: {said!r}" if said else ""
