"""The safety envelope: limits of recorded signals."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from gmfbo.errors import RecordingError, did_you_mean
from gmfbo.objective.condition import Condition
from gmfbo.recordings.recording import Recording, Trajectory


@dataclass(frozen=True)
class Exit:
    """First exit of a run from the envelope.

    Attributes
    ----------
    row : int
        First row that is outside.
    reason : str
        Signal or condition, in one line.
    """

    row: int
    reason: str


@dataclass(frozen=True)
class Envelope:
    """Ranges of recorded signals, and a condition on them.

    Attributes
    ----------
    ranges : mapping of str to (float, float)
        Lowest and highest value by signal [unit of the signal].
    condition : Condition or None
        Must hold in each row.
    """

    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    condition: Condition | None = None

    def __bool__(self) -> bool:
        return bool(self.ranges) or self.condition is not None

    def first_exit(self, run: Recording, *, all_signals: bool = True) -> Exit | None:
        """Find where a run leaves the envelope first.

        Parameters
        ----------
        run : Recording
            Measured or simulated; blank cells are ignored.
        all_signals : bool
            Raise for a run that lacks a signal; otherwise ignore limits of missing signals.

        Returns
        -------
        Exit or None
            None where the run stays inside.

        Raises
        ------
        RecordingError
            The run lacks a signal, so that its safety cannot be judged.
        """
        if all_signals:
            self._check_signals(run)
        exits = []
        for name, (low, high) in self.ranges.items():
            if name not in run.signals:
                continue
            values = run.signals[name]
            outside = (values < low) | (values > high)
            if outside.any():
                row = int(np.argmax(outside))
                unit = f" {run.units[name]}" if name in run.units else ""
                exits.append(
                    Exit(row, f"{name} = {values[row]:.4g}{unit} outside [{low:g}, {high:g}]")
                )
        condition = self.condition
        if condition is not None and condition.names <= set(run.signals):
            broken = ~condition.holds(run.time, run.signals)
            if broken.any():
                exits.append(Exit(int(np.argmax(broken)), f"not {condition.text}"))
        return min(exits, key=lambda left: left.row, default=None)

    def judge(self, run: Recording) -> Recording:
        """Mark a run of the real axis that leaves the envelope.

        Parameters
        ----------
        run : Recording
            A simulated run (`Trajectory`) is cut at its exit, where the plant would be stopped. A
            measured one is kept whole.

        Returns
        -------
        Recording
            The run itself, or a `Trajectory` of status `unsafe`.

        Raises
        ------
        RecordingError
            The run lacks a signal, so that its safety cannot be judged.
        """
        simulated = isinstance(run, Trajectory)
        if not self or (isinstance(run, Trajectory) and run.status == "unsafe"):
            return run
        # A failed run may have stopped before it wrote a row.
        whole = not (isinstance(run, Trajectory) and run.status != "ok")
        left = self.first_exit(run, all_signals=whole)
        if left is None:
            return run
        kept = slice(None, left.row + 1) if simulated else slice(None)
        return Trajectory(
            time=run.time[kept],
            signals={name: values[kept] for name, values in run.signals.items()},
            units=run.units,
            name=run.name,
            parameters=run.parameters,
            schedules={name: values[kept] for name, values in run.schedules.items()},
            use=run.use,
            start_time=run.start_time,
            written_by=run.written_by,
            status="unsafe",
            message=f"left the safety envelope at {run.time[left.row]:.4g} s: {left.reason}",
            stopped_at=float(run.time[left.row]),
            seconds=run.seconds if isinstance(run, Trajectory) else run.duration,
        )

    def _check_signals(self, run: Recording) -> None:
        wanted = {*self.ranges, *(self.condition.names if self.condition else ())}
        for name in sorted(wanted - set(run.signals)):
            raise RecordingError(
                f"{run.name or 'run'}: [safety] speaks of '{name}', which the run does not hold"
                + did_you_mean(name, run.signals)
            )
