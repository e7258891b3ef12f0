"""Pieces of long recordings that excite most, where all of them would take hours to compare."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin.twin import FmuTwin

Array = NDArray[np.float64]

MOST_STEPS = 60_000
"""Communication steps of all recordings together that are compared: minutes on two cores."""

PIECE_STEPS = 4_000
_LEAST_ROWS = 256  # of a piece
_LEAD = 0.25  # of a piece: simulated before it and not scored, until its start is forgotten
_LEAST_SEEN = 0.5  # of a piece's rows, with a signal to compare
_KNOWN_BEFORE = 1e-3  # of all rows, in each direction: a first piece has to show something


@dataclass(frozen=True, eq=False)
class _Piece:
    """Rows of a recording, and what they show: the Gram matrix of its regressors."""

    recording: int
    rows: slice
    gram: Array


def exciting_pieces(
    recordings: Sequence[Recording], twin: FmuTwin
) -> tuple[list[Recording], list[str]]:
    """Recordings as they are, or of long ones the pieces that excite most.

    Pieces are taken one by one, each that with which the determinant of the information grows most
    (Fedorov 1972). Regressors are each signal, its square, its rate and that rate's direction:
    laws of friction, load and loss are made of these.

    Parameters
    ----------
    recordings : sequence of Recording
        As they were read.
    twin : FmuTwin
        Its step tells how long they take to simulate, its file which signals count.

    Returns
    -------
    tuple of list of Recording and list of str
        What is compared, and a note where it is not all.
    """
    durations = [_used(recording)[1] - _used(recording)[0] for recording in recordings]
    if sum(durations) / twin.step <= MOST_STEPS:
        return list(recordings), []
    pieces = _pieces(recordings, twin)
    if not pieces:  # nothing to compare: who opens them says so
        return list(recordings), []
    chosen = _chosen(pieces, [_steps(recordings, piece, twin) for piece in pieces])
    found = _joined(recordings, chosen)
    told = sum(_used(recording)[1] - _used(recording)[0] for recording in found)
    if told > 0.99 * sum(durations):  # one piece of a slow logger may be more than is wanted
        return list(recordings), []
    return found, [
        f"{told:.3g} of {sum(durations):.3g} s were compared, those that excite most: all of it "
        "would take hours"
    ]


def _used(recording: Recording) -> tuple[float, float]:
    """[s] First and last time that may be scored."""
    first, last = float(recording.time[0]), float(recording.time[-1])
    if recording.use is None:
        return first, last
    return max(first, recording.use[0]), max(first, min(last, recording.use[1]))


def _pieces(recordings: Sequence[Recording], twin: FmuTwin) -> list[_Piece]:
    names = [*twin.file.inputs, *twin.file.outputs]
    regressors = [_regressors(recording, names) for recording in recordings]
    square = sum(np.sum(own**2, axis=1) for own in regressors)
    rows = sum(own.shape[1] for own in regressors)
    scale = np.sqrt(square / rows)
    found = []
    for k, (recording, own) in enumerate(zip(recordings, regressors, strict=True)):
        spacing = recording.duration / max(1, len(recording) - 1)
        length = max(round(PIECE_STEPS * twin.step / spacing), _LEAST_ROWS)
        begin, last = np.searchsorted(recording.time, _used(recording))
        end = min(int(last) + 1, len(recording))
        count = max(1, (end - int(begin)) // length)
        edges = np.linspace(begin, end, count + 1).astype(int)
        seen = np.any([_known(recording, name) for name in twin.file.outputs], axis=0)
        for first, last in pairwise(edges):
            if np.mean(seen[first:last]) < _LEAST_SEEN:
                continue
            part = np.divide(
                own[:, first:last],
                scale[:, None],
                where=scale[:, None] > 0.0,
                out=np.zeros((scale.size, last - first)),
            )
            found.append(_Piece(k, slice(int(first), int(last)), part @ part.T / rows))
    return found


def _regressors(recording: Recording, names: Sequence[str]) -> Array:
    """Each signal about its mean, its square, its rate and that rate's direction, shape (4k, n).

    Nothing where a signal is blank.
    """
    made = []
    for name in names:
        column = np.zeros(len(recording))
        known = _known(recording, name)
        if known.sum() > 1:
            there = recording.time[known]
            column = np.interp(recording.time, there, recording.signals[name][known])
            column = (column - column[known].mean()) * known
        rate = np.gradient(column, recording.time) * known
        usual = float(np.sqrt(np.mean(rate**2))) or 1.0
        made += [column, column**2, rate, np.tanh(rate / usual)]
    return np.array(made)


def _known(recording: Recording, name: str) -> NDArray[np.bool_]:
    """Rows in which a signal is not blank; none where it was not recorded."""
    return np.isfinite(recording.signals.get(name, np.full(len(recording), np.nan)))


def _steps(recordings: Sequence[Recording], piece: _Piece, twin: FmuTwin) -> float:
    time = recordings[piece.recording].time[piece.rows]
    return float(time[-1] - time[0]) / twin.step


def _chosen(pieces: Sequence[_Piece], steps: Sequence[float]) -> list[_Piece]:
    """Pieces in order, as many as may be compared."""
    left, spent = list(range(len(pieces))), 0.0
    chosen: list[int] = []
    information = _KNOWN_BEFORE * np.eye(len(pieces[0].gram))
    while left:
        grown = [np.linalg.slogdet(information + pieces[i].gram)[1] for i in left]
        best = left.pop(int(np.argmax(grown)))
        if chosen and spent + steps[best] > MOST_STEPS:
            break
        chosen.append(best)
        spent += steps[best]
        information = information + pieces[best].gram
    return [pieces[i] for i in sorted(chosen)]


def _joined(recordings: Sequence[Recording], chosen: Sequence[_Piece]) -> list[Recording]:
    """Recordings of the pieces, those that lie end to end as one."""
    runs: list[tuple[int, int, int]] = []
    for piece in chosen:
        if runs and runs[-1][0] == piece.recording and runs[-1][2] == piece.rows.start:
            runs[-1] = (piece.recording, runs[-1][1], piece.rows.stop)
        else:
            runs.append((piece.recording, piece.rows.start, piece.rows.stop))
    lengths = {piece.recording: piece.rows.stop - piece.rows.start for piece in chosen}
    return [_cut(recordings[k], first, last, int(_LEAD * lengths[k])) for k, first, last in runs]


def _cut(recording: Recording, first: int, last: int, lead: int) -> Recording:
    """A stretch of a recording, of which what comes after a lead is scored."""
    time, before = recording.time, max(0, first - lead)
    if (before, last) == (0, len(recording)):
        return recording
    rows = slice(before, last)
    use = _used(recording)
    return replace(
        recording,
        time=time[rows],
        signals={name: column[rows] for name, column in recording.signals.items()},
        schedules={name: column[rows] for name, column in recording.schedules.items()},
        use=(max(use[0], float(time[first])), min(use[1], float(time[last - 1]))),
        name=f"{recording.name} [{time[first]:.13g}, {time[last - 1]:.13g}] s",
    )
