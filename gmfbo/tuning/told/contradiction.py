"""Whether a recording follows the reference that was asked for."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import RecordingError
from gmfbo.recordings.recording import Recording
from gmfbo.recordings.reference import followed_signal

# A column without its unit, by the factor that it is off.
_MISTAKEN = {
    180.0 / np.pi: "degrees where rad was asked for; write the unit into the header, NAME [deg]",
    np.pi / 180.0: "rad where degrees were meant",
    1e3: "a unit 1000 times smaller, such as mm for m; write it into the header, NAME [mm]",
    1e-3: "a unit 1000 times larger",
    0.5 / np.pi: "turns where rad was asked for; write the unit into the header, NAME [rev]",
}
_LIKE = 0.01  # relative difference from such a factor


def refuse_other_reference(reference: Recording, run: Recording, share: float) -> None:
    """Raise for a recording whose own reference is another than was asked for.

    A recording without a column of the reference contradicts nothing.

    Parameters
    ----------
    reference : Recording
        What was asked for.
    run : Recording
        What was measured, on the clock of the reference.
    share : float
        RMS difference that is taken for the logger's resolution, as a share of the range of the
        reference: the half width of the settling band, within which an error counts as none.

    Raises
    ------
    RecordingError
        It follows another reference: by how much, and what it may be.
    """
    name = followed_signal(reference)
    seen = run.signals.get(name)
    if seen is None:
        return
    inside = np.isfinite(seen) & (run.time >= reference.time[0]) & (run.time <= reference.time[-1])
    if not inside.any():
        return
    asked = reference.signals[name]
    clear = inside & ~_beside_changes(reference.time, asked, run.time)
    if not clear.any():
        return
    wanted = np.interp(run.time[clear], reference.time, asked)
    logged = seen[clear]
    size = float(np.ptp(asked)) or float(np.abs(asked).max()) or 1.0
    apart = float(np.sqrt(np.mean((logged - wanted) ** 2)))
    if apart <= share * size:
        return
    label = run.name or "recording"
    unit = reference.units.get(name, "")
    raise RecordingError(
        f"{label}: its '{name}' goes from {logged.min():g} to {logged.max():g}, but "
        f"{asked.min():g} to {asked.max():g} {unit}".rstrip()
        + f" was asked for{_guess(wanted, logged, share)}; record again, or take it as it is "
        "(--anyway)"
    )


def _beside_changes(
    time: NDArray[np.float64], values: NDArray[np.float64], at: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Which instants lie within a sample of a jump, where logger and request may be one off."""
    jumps = np.flatnonzero(np.abs(np.diff(values)) > 0.0)
    # A smooth reference changes all the time; it has no jumps to be spared.
    if at.size < 2 or jumps.size > 0.5 * time.size:
        return np.zeros(at.shape, dtype=bool)
    step = max(float(np.median(np.diff(at))), float(np.median(np.diff(time))))
    nearest = np.searchsorted(time[jumps], at)
    before = time[jumps][np.maximum(nearest - 1, 0)] if jumps.size else np.full(at.shape, -np.inf)
    after = (
        time[np.minimum(jumps + 1, time.size - 1)][np.minimum(nearest, jumps.size - 1)]
        if jumps.size
        else np.full(at.shape, np.inf)
    )
    return np.asarray((np.abs(at - before) <= 2.0 * step) | (np.abs(after - at) <= 2.0 * step))


def _guess(wanted: NDArray[np.float64], logged: NDArray[np.float64], share: float) -> str:
    """What the difference may be, where a factor explains it."""
    moved = float(np.dot(wanted, wanted))
    factor = float(np.dot(logged, wanted)) / moved if moved > 0.0 else 0.0
    rest = float(np.sqrt(np.mean((logged - factor * wanted) ** 2)))
    if factor == 0.0 or rest > share * float(np.abs(logged).max()):
        return ""
    for known, words in _MISTAKEN.items():
        if abs(factor / known - 1.0) < _LIKE:
            return f" (perhaps {words})"
    return f" ({factor:.4g} times as much)"
