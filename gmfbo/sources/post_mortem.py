"""What to say of a worker that crashed, left or hung."""

from __future__ import annotations

import signal
from collections.abc import Sequence
from dataclasses import dataclass

from gmfbo.sources.job import Stage

_WINDOWS_FAULTS = {0xC0000005: "access violation", 0xC00000FD: "stack overflow"}
_CURES = {
    Stage.LOAD: "ask its vendor for a build for this system",
    Stage.INSTANTIATE: "check that its licence and resources are in place, or ask its vendor",
    Stage.INITIALISE: "check its parameters and initial values, or ask its vendor",
}


@dataclass(frozen=True)
class WhereItStood:
    """What is known of a worker that gave no answer.

    Attributes
    ----------
    names : sequence of str
        FMUs in order of computation.
    stage : Stage
        What the worker was busy with.
    fmu : int
        Which FMU, outside of steps.
    time : float or None
        [s] Last communication point that was reached.
    said : str
        What it printed last.
    """

    names: Sequence[str]
    stage: Stage
    fmu: int
    time: float | None
    said: str

    @property
    def who(self) -> str:
        """FMU that is to blame, or all that stepped together."""
        if self.stage == Stage.STEP and len(self.names) > 1:
            return "one of " + ", ".join(f"'{name}'" for name in self.names)
        return f"'{self.names[self.fmu]}'"

    @property
    def doing(self) -> str:
        """What it was doing, and when."""
        at = f" after t = {self.time:g} s" if self.time is not None else ""
        return self.stage.words + (at if self.stage == Stage.STEP else "")

    @property
    def quote(self) -> str:
        """Its last words, to append."""
        return f"; it printed last: {self.said!r}" if self.said else ""


def crash_message(where: WhereItStood, exit_code: int) -> str:
    """One line on a worker that is gone.

    Parameters
    ----------
    where : WhereItStood
        What is known.
    exit_code : int
        Negative where a signal ended it.
    """
    cure = _CURES.get(where.stage, "try other gains or parameters, or ask its vendor")
    return f"{where.who} {_end(exit_code)} while {where.doing}; {cure}{where.quote}"


def timeout_message(where: WhereItStood, limit_s: float) -> str:
    """One line on a worker that did not answer in time.

    Parameters
    ----------
    where : WhereItStood
        What is known.
    limit_s : float
        [s] Wall-clock time that it had.
    """
    return (
        f"{where.who} did not finish within {limit_s:g} s, stopped while {where.doing}; raise "
        f"time_limit_s if it is slow, else it hangs there{where.quote}"
    )


def _end(exit_code: int) -> str:
    if exit_code in _WINDOWS_FAULTS:
        return f"crashed ({_WINDOWS_FAULTS[exit_code]})"
    if exit_code >= 0:
        return f"ended its process with exit code {exit_code}"
    try:
        return f"crashed ({signal.Signals(-exit_code).name})"
    except ValueError:
        return f"crashed (signal {-exit_code})"
