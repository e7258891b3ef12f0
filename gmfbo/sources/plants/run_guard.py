"""The abort of a run, in the process that runs the plant.

gmfbo sees a recording when the run is over. What has to end a run while it lasts must live beside
the axis, in the program that gmfbo calls::

    guard = RunGuard.read(request)                  # FILE of --request
    for each sample:
        if reason := guard.check(t, {"position": q, "torque_command": u}, taken=taken):
            set_gains(guard.safe_gains)             # back to the last gains that stayed inside
            break
    write_recording(..., parameters={**gains, **guard.parameters})

It is no safety function, and replaces no limit of the drive: a program that hangs checks nothing.
"""

from __future__ import annotations

import json
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Self

import numpy as np

from gmfbo.errors import InputError
from gmfbo.objective.condition import Condition
from gmfbo.objective.envelope import Envelope
from gmfbo.recordings.recording import Recording
from gmfbo.sources.plants.heartbeat import lost

LATENCY = "abort_latency_s"
"""Parameter of a recording by which a plant's program says that it aborted the run, and how long
[s] it took from the sample to the abort."""


@dataclass(eq=False)
class RunGuard:
    """Watches one run, sample by sample.

    Attributes
    ----------
    envelope : Envelope
        Safety envelope of the study; empty where it has none.
    safe_gains : mapping of str to float
        Gains of the last run inside the envelope, or those in force; empty before either is known.
    heartbeat : Path or None
        File that gmfbo touches while it waits; None where nobody does.
    lost_after_s : float
        [s] Time without a beat after which nobody waits for the run any more.
    latency_s : float
        [s] Longest time from a sample to the end of its check so far.
    reason : str
        Why the run was aborted; empty while it was not.
    """

    envelope: Envelope
    safe_gains: Mapping[str, float] = field(default_factory=dict)
    heartbeat: Path | None = None
    lost_after_s: float = 0.0
    latency_s: float = 0.0
    reason: str = ""

    @classmethod
    def read(cls, request: str | Path) -> Self:
        """Make the guard of a run from the request file that a program is given.

        Parameters
        ----------
        request : str or Path
            FILE of `--request FILE`.

        Raises
        ------
        InputError
            It is no request of gmfbo.
        """
        try:
            content = json.loads(Path(request).read_text(encoding="utf-8"))
            safety, beat = content.get("safety", {}), content.get("heartbeat")
        except (OSError, ValueError, AttributeError) as error:
            raise InputError(
                f"{request}: expected the file that gmfbo names by --request, got: {error}"
            ) from None
        formula = safety.get("expression")
        ranges = {name: (low, high) for name, (low, high) in safety.get("ranges", {}).items()}
        return cls(
            envelope=Envelope(ranges, None if formula is None else Condition.parse(formula)),
            safe_gains=content.get("safe_gains", {}),
            heartbeat=Path(beat["file"]) if beat else None,
            lost_after_s=beat["lost_after_s"] if beat else 0.0,
        )

    def check(self, t: float, sample: Mapping[str, float], *, taken: float | None = None) -> str:
        """Reason to abort the run now; empty where it may go on.

        Parameters
        ----------
        t : float
            [s] Time of the sample on the clock of the reference.
        sample : mapping of str to float
            Signals by name, in SI; those of the envelope that are missing are not checked.
        taken : float, optional
            [s] `time.perf_counter()` when the sample was taken, from which the latency counts;
            the begin of this call unless given.
        """
        begun = time.perf_counter() if taken is None else taken
        signals = {name: np.array([value]) for name, value in sample.items()}
        run = Recording(time=np.array([t]), signals=signals)
        left = self.envelope.first_exit(run, all_signals=False)
        if left is not None:
            self.reason = f"left the safety envelope: {left.reason}"
        elif self.heartbeat is not None and lost(self.heartbeat, self.lost_after_s):
            self.reason = f"no heartbeat for {self.lost_after_s:g} s: nobody waits for this run"
        self.latency_s = max(self.latency_s, time.perf_counter() - begun)
        return self.reason

    @property
    def parameters(self) -> dict[str, float]:
        """Lines for the recording: the latency [s] of an abort; none of a run that was not."""
        return {LATENCY: self.latency_s} if self.reason else {}
