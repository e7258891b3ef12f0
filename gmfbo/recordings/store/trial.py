"""Trial: one run of an information source, with its provenance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from gmfbo.recordings.recording import Recording

SourceName = Literal["IS1", "IS2", "IS3"]


@dataclass(frozen=True, eq=False)
class Trial:
    """A finished run: trajectory, gains, cost and provenance.

    Attributes
    ----------
    number : int
        1, 2, 3 ... in the order in which trials were asked for; names the file.
    source : {"IS1", "IS2", "IS3"}
        Real axis, twin, or twin corrected by the trajectory Gaussian process.
    gains : mapping of str to float
        FMU parameter = value in force.
    recording : Recording
        Trajectory (simulated) or recording (measured); IS3: the corrected signals.
    objective : float
        Weighted, normalised cost, to be minimised.
    metrics : mapping of str to float
        Each metric before normalising.
    status : str
        `ok`, or how the run ended early.
    started : str
        ISO 8601 time, UTC.
    seconds : float
        [s] Wall-clock time of the run.
    seed : int
        Seed of the study.
    twin : str
        Content hash of the twin that ran; empty for a plant that is not an FMU.
    parent : int or None
        IS1 trial that caused this IS2 or IS3 run.
    sigma_c : float or None
        IS3: root mean posterior variance of the correction [unit of the signal].
    accepted : bool or None
        IS3: whether the draw was used.
    uncorrected, std : mapping of str to ndarray, shape (n,)
        IS3: each corrected signal before correction, and its posterior standard deviation.
    late_error : float or None
        Late error over what counts as settled, at most 1 where the run settled, infinite where
        it failed; None in studies whose failed runs have a price instead.
    versions : mapping of str to str
        Version of each package that decides the result; the store fills it in when empty.
    """

    number: int
    source: SourceName
    gains: Mapping[str, float]
    recording: Recording
    objective: float
    metrics: Mapping[str, float]
    status: str = "ok"
    started: str = ""
    seconds: float = 0.0
    seed: int = 0
    twin: str = ""
    parent: int | None = None
    sigma_c: float | None = None
    accepted: bool | None = None
    late_error: float | None = None
    uncorrected: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)
    std: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=dict)

    @property
    def bare(self) -> bool:
        """Whether gains and metrics of the run are known, but no signal: a row of a table."""
        return self.status == "ok" and not self.recording.signals
