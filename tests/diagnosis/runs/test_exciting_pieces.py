"""Ten minutes of a log: what is compared of them, and that nothing of it is changed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo import FmuTwin, models_folder
from gmfbo.diagnosis.runs.exciting_pieces import MOST_STEPS, exciting_pieces
from gmfbo.recordings.recording import Recording

MINUTES = 10


def bench() -> FmuTwin:
    return FmuTwin(models_folder() / "motor_bench.toml")


def log(busy: NDArray[np.bool_], seed: int = 0) -> Recording:
    """Current and position of an axis that moves in busy seconds and else only shakes."""
    rng = np.random.default_rng(seed)
    time = np.arange(1000 * busy.size, dtype=np.float64) * 1e-3
    moves = np.repeat(busy, 1000).astype(np.float64) * np.sin(2.0 * np.pi * 0.7 * time)
    position = np.cumsum(moves) * 1e-3 + 1e-5 * rng.standard_normal(time.size)
    signals = {"current": moves, "position": position}
    return Recording(time=time, signals=signals, name="long.csv", use=(1.0, 590.0))


def test_what_is_short_stays_as_it_is() -> None:
    recording = log(np.ones(60, dtype=bool))
    with bench() as twin:
        (same,), notes = exciting_pieces([recording], twin)
    assert same is recording
    assert notes == []


def test_of_ten_minutes_the_stretches_that_move_are_compared() -> None:
    busy = np.zeros(60 * MINUTES, dtype=bool)
    for start in (40, 200, 204, 420):
        busy[start : start + 4] = True
    recording = log(busy)
    with bench() as twin:
        pieces, (note,) = exciting_pieces([recording], twin)
    scored = [piece.use[1] - piece.use[0] for piece in pieces if piece.use is not None]
    assert sum(scored) <= MOST_STEPS * 1e-3
    assert len(scored) == len(pieces)
    inside = np.zeros(recording.time.size, dtype=bool)
    for piece in pieces:
        rows = np.searchsorted(recording.time, piece.time)
        inside[rows] = True
        for name, column in piece.signals.items():
            assert np.array_equal(column, recording.signals[name][rows])
        assert piece.use is not None
        assert piece.use[1] <= 590.0
        if piece.time[0] > 0.0:  # the start is forgotten before it is scored
            assert piece.use[0] == pytest.approx(piece.time[0] + 1.0, abs=0.01)
    assert inside[np.repeat(busy, 1000)].all()
    assert "of 589 s were compared" in note


def test_only_what_is_used_counts_and_is_cut() -> None:
    recording = log(np.ones(120, dtype=bool))
    with bench() as twin:
        (same,), notes = exciting_pieces([replace(recording, use=(100.0, 110.0))], twin)
        late, _ = exciting_pieces([replace(recording, use=(40.0, 119.0))], twin)
    assert (len(same), notes) == (len(recording), [])
    assert all(piece.use is not None and 40.0 <= piece.use[0] < piece.use[1] for piece in late)


def test_pieces_of_a_clock_that_counts_from_1970_have_names_of_their_own() -> None:
    recording = log(np.arange(600) % 20 < 4)
    epoch = replace(recording, time=recording.time + 1.7e9, use=None)
    with bench() as twin:
        pieces, _ = exciting_pieces([epoch], twin)
    assert len({piece.name for piece in pieces}) == len(pieces) > 1


def test_what_is_blank_excites_nothing() -> None:
    recording = log(np.ones(120, dtype=bool))
    blank = np.where(recording.time < 60.0, np.nan, recording.signals["position"])
    recording = replace(recording.with_signals({"position": blank}), use=None)
    with bench() as twin:
        pieces, _ = exciting_pieces([recording], twin)
    seen = [
        p.signals["position"][(p.time >= p.use[0]) & (p.time <= p.use[1])] for p in pieces if p.use
    ]
    assert np.mean(np.isfinite(np.concatenate(seen))) > 0.9


def test_pieces_that_lie_end_to_end_are_one() -> None:
    busy = np.zeros(60 * MINUTES, dtype=bool)
    busy[200:232] = True
    with bench() as twin:
        pieces, _ = exciting_pieces([log(busy)], twin)
    assert any(piece.time[0] <= 200.0 and piece.time[-1] >= 231.9 for piece in pieces)


def test_who_moves_both_ways_is_taken_before_who_moves_one_way_longer() -> None:
    time = np.arange(60_000, dtype=np.float64) * 1e-3
    made = []
    for k in range(8):
        moves = np.ones(time.size) if k else np.sign(np.sin(2.0 * np.pi * 0.2 * time))
        signals = {"current": moves, "position": np.cumsum(moves) * 1e-3}
        made.append(Recording(time=time, signals=signals, name=f"{k}.csv"))
    with bench() as twin:
        pieces, _ = exciting_pieces(made[::-1], twin)
    taken = [sum(p.duration for p in pieces if p.name.startswith(f"{k}.csv")) for k in range(8)]
    assert taken[0] > 1.3 * max(taken[1:])
