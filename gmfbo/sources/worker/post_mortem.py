"""Messages about a worker that crashed, exited or hung."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gmfbo.interrupt import signal_name
from gmfbo.sources.fmu_file.job import Stage
from gmfbo.sources.sandbox.policy import VARIABLE, Policy

_WINDOWS_FAULTS = {0xC0000005: "access violation", 0xC00000FD: "stack overflow"}
_CALLS = {
    (Stage.INSTANTIATE, 2): "fmi2Instantiate",
    (Stage.INSTANTIATE, 3): "fmi3InstantiateCoSimulation",
    (Stage.INITIALISE, 2): "between fmi2SetupExperiment and fmi2ExitInitializationMode",
    (Stage.INITIALISE, 3): "fmi3EnterInitializationMode or fmi3ExitInitializationMode",
    (Stage.STEP, 2): "fmi2DoStep, or setting or reading values",
    (Stage.STEP, 3): "fmi3DoStep, or setting or reading values",
    (Stage.FREE, 2): "fmi2FreeInstance",
    (Stage.FREE, 3): "fmi3FreeInstance",
}
_NEARLY_ALL = 0.8
_LONGEST_LINE = 2000
_CURES = {
    Stage.LOAD: "ask its vendor for a build for this system",
    Stage.INSTANTIATE: "check that its licence and resources are in place, or ask its vendor",
    Stage.INITIALISE: "check its parameters and initial values, or ask its vendor",
}


@dataclass(frozen=True)
class WhereItStood:
    """Last known state of a worker that gave no answer.

    Attributes
    ----------
    names : sequence of str
        FMUs in order of computation.
    stage : Stage
        Stage of the worker's run.
    fmu : int
        Index of the FMU, outside of steps.
    time : float or None
        [s] Last communication point reached.
    said : str
        End of what it printed, in one line.
    policy : Policy
        Sandbox policy of the worker.
    held : int
        [bytes] Its peak memory; 0 where unknown.
    versions : sequence of int
        Major version of FMI of each FMU.
    """

    names: Sequence[str]
    stage: Stage
    fmu: int
    time: float | None
    said: str
    policy: Policy
    held: int
    versions: Sequence[int] = ()

    @property
    def call(self) -> str:
        """FMI call that it worked on, in brackets with a blank in front; empty while loading."""
        majors = self.versions if self.stage == Stage.STEP else self.versions[self.fmu :][:1]
        calls = [_CALLS.get((self.stage, major), "") for major in dict.fromkeys(majors)]
        return f" ({' or '.join(filter(None, calls))})" if any(calls) else ""

    @property
    def ran_out_of_memory(self) -> bool:
        """Whether the worker had reached its memory limit."""
        limit = self.policy.memory_limit if self.policy.enclosed else 0
        return limit > 0 and self.held > _NEARLY_ALL * limit

    @property
    def who(self) -> str:
        """FMU to blame, or all FMUs that were stepped together."""
        if self.stage == Stage.STEP and len(self.names) > 1:
            return "one of " + ", ".join(f"'{name}'" for name in self.names)
        return f"'{self.names[self.fmu]}'"

    @property
    def doing(self) -> str:
        """Words for the stage and time of the run."""
        at = f" after t = {self.time:g} s" if self.time is not None else ""
        return self.stage.words + (at if self.stage == Stage.STEP else "")

    @property
    def quote(self) -> str:
        """End of what the worker printed, to append to a message."""
        return f"; it printed last: {self.said!r}" if self.said else ""


def crash_message(where: WhereItStood, exit_code: int) -> str:
    """One line about a dead worker.

    Parameters
    ----------
    where : WhereItStood
        Last known state.
    exit_code : int
        Negative where a signal ended it.
    """
    cure = _CURES.get(where.stage, "try other gains or parameters, or ask its vendor")
    if where.ran_out_of_memory:
        cure = (
            f"it held {where.held / 1e9:.3g} GB and may hold {where.policy.memory_limit / 1e9:.3g} "
            f"GB: ask its vendor about a leak, or allow more by {VARIABLE}=memory=GB"
        )
    elif signal_name(exit_code) == "SIGKILL":
        cure = "somebody killed it, or the system did for want of memory"
    elif signal_name(exit_code) == "SIGXCPU":
        cure = (
            "it used more processor time than its time limit on all cores; raise time_limit in the "
            "twin file if it is slow"
        )
    elif where.stage in _CURES and where.policy.enclosed:
        cure += f"; if it needs a licence server or files of yours, {VARIABLE} can let it"
    return f"{where.who} {_end(exit_code)} while {where.doing}; {cure}{where.quote}"


def garbled_message(names: Sequence[str]) -> str:
    """One line about a worker with an invalid answer."""
    who = " or ".join(f"'{name}'" for name in names)
    return (
        f"{who} spoiled the run: it writes to files of the process that it runs in, where gmfbo's "
        "answers go; ask its vendor"
    )


def plain_line(text: object) -> str:
    """Text of foreign code as one line without control characters.

    Parameters
    ----------
    text : object
        A text, if the foreign code behaved.
    """
    line = " ".join(str(text).split())[:_LONGEST_LINE]
    return "".join(letter if letter.isprintable() else "?" for letter in line)


def timeout_message(where: WhereItStood, limit_s: float) -> str:
    """One line about a worker that did not answer in time.

    Parameters
    ----------
    where : WhereItStood
        Last known state.
    limit_s : float
        [s] Its wall-clock limit.
    """
    if where.stage == Stage.LOAD:
        return (
            f"{where.who} did not load within {limit_s:g} s: it hangs there, or waits for a "
            f"licence server; ask its vendor{where.quote}"
        )
    return (
        f"{where.who} did not finish within {limit_s:g} s, stopped while {where.doing}"
        f"{where.call}; raise time_limit in the twin file if it is slow, else it hangs there"
        f"{where.quote}"
    )


def _end(exit_code: int) -> str:
    if exit_code in _WINDOWS_FAULTS:
        return f"crashed ({_WINDOWS_FAULTS[exit_code]})"
    if exit_code >= 0:
        return f"ended its process with exit code {exit_code}"
    return f"crashed ({signal_name(exit_code)})"
