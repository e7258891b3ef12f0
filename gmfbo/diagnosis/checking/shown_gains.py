"""Gains that the drive really had, where the recorded command contradicts the stated ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gmfbo.diagnosis.checking.nominal_case import open_nominal
from gmfbo.diagnosis.checking.seen_alignment import LEAST_GAIN, ControllerView, against_controller
from gmfbo.diagnosis.locating.parity import FAILS_ABOVE
from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin.twin import FmuTwin

_EXPLAINED = 0.9  # share of the controller's residual that one gain explains
_OTHERS_LEAVE = 2.0  # times the residual left by the gain: any column error leaves more
_ALIKE = 0.01  # relative difference of the gain allowed between recordings


@dataclass(frozen=True)
class ShownGain:
    """A controller gain that differed from the stated one in all recordings.

    Attributes
    ----------
    name : str
        As the twin file names it.
    nominal : float
        [FMU's unit] In force where a recording states none.
    ratio : float
        Gain shown by the command over the stated gain [1].
    """

    name: str
    nominal: float
    ratio: float

    def put_in(self, recordings: Sequence[Recording]) -> list[Recording]:
        """Recordings with the shown gain stated in them."""
        changed = []
        for recording in recordings:
            stated = recording.parameters.get(self.name, self.nominal)
            gains = {**recording.parameters, self.name: self.ratio * stated}
            changed.append(replace(recording, parameters=gains))
        return changed

    @property
    def note(self) -> str:
        """Message for the user."""
        return (
            f"the controller's command shows that {self.name} was {self.ratio:.3f} times what the "
            "recordings state or the twin has: the diagnosis uses what the command shows; state "
            f"it in the recordings, # {self.name} = VALUE"
        )


def find_shown_gain(
    twin: FmuTwin, recordings: Sequence[Recording], *, seed: int, jobs: int | None
) -> ShownGain | None:
    """Find a wrongly stated gain by the controller's parity; None where all are as stated.

    Most recordings have to show the same gain with the same ratio, and no shift, scale or offset
    of a column may explain the command as well.

    Parameters
    ----------
    twin : FmuTwin
        The user's twin.
    recordings : sequence of Recording
        Runs of the real axis.
    seed : int
        Of the noise runs.
    jobs : int or None
        Simulators; None for one a processor.

    Raises
    ------
    RecordingError
        There is nothing to compare.
    SimulationError
        The twin as it is cannot follow a recording.
    """
    if not twin.file.gains or "command" not in twin.file.states:
        # Without a recorded command or a gain nothing can be shown: save the simulations.
        return None
    nominal = open_nominal(twin, recordings, seed=seed, jobs=jobs, on_run=lambda: None)
    case = nominal.case
    try:
        views = against_controller(case, nominal.checked, nominal.rows)
    finally:
        case.simulations.close()
    found = [told for told in map(_told_by, views) if told is not None]
    names = {name for name, _ in found}
    if len(names) != 1 or 2 * len(found) <= len(views):
        return None
    (name,) = names
    sizes = np.array([size for _, size in found])
    if np.ptp(sizes) > _ALIKE or name in twin.parameters or name in _scheduled(recordings):
        return None
    return ShownGain(name, twin.nominal(name), 1.0 + float(np.median(sizes)))


def _scheduled(recordings: Sequence[Recording]) -> set[str]:
    """Gains that changed during a run; they are left as stated."""
    return {name for recording in recordings for name in recording.schedules}


def _told_by(view: ControllerView) -> tuple[str, float] | None:
    """Gain that one recording's command shows, and its ratio to the stated gain minus one [1]."""
    if view.excess <= FAILS_ABOVE:
        return None
    best = view.culprits[0]
    if best.kind != "gain" or best.explained < _EXPLAINED or abs(best.size) <= LEAST_GAIN:
        return None
    others = max((c.explained for c in view.culprits if c.kind != "gain"), default=0.0)
    if 1.0 - others < _OTHERS_LEAVE * (1.0 - best.explained):
        return None
    return best.signal, best.size
