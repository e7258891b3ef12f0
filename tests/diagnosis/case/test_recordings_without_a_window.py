"""A recording that ends before its start is forgotten is left out, and said to be."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace

import numpy as np

from gmfbo.diagnosis.case.held_out_split import split_of
from gmfbo.recordings.recording import Recording
from tests.diagnosis.short_recordings import SERVO, moves, multisine, open_small, triangle

TOLD = "rec3.csv: not scored"


def four(elsewhere: float) -> list[Recording]:
    """Four recordings; the last is short, and begins `elsewhere` [rad]."""
    made = SERVO.recordings({}, (multisine, moves, triangle, multisine))
    rows = slice(0, 120)
    signals = {name: column[rows] for name, column in made[3].signals.items()}
    signals["position"] = signals["position"] + elsewhere * np.ones(120)
    return [*made[:3], replace(made[3], time=made[3].time[rows], signals=signals)]


def test_it_is_neither_fitted_nor_held_out_and_a_note_says_so() -> None:
    with closing((case := open_small(SERVO.twin(), four(0.5))).simulations):
        split = split_of(case, [], case.base)
        assert {*split.names_fitted, *split.names_held_out} == {"rec0.csv", "rec1.csv", "rec2.csv"}
        assert split.held_out
        assert any(note.startswith(TOLD) for note in case.notes)


def test_control_one_that_starts_as_its_twin_is_used() -> None:
    with closing((case := open_small(SERVO.twin(), four(0.0))).simulations):
        split = split_of(case, [], case.base)
        assert "rec3.csv" in {*split.names_fitted, *split.names_held_out}
        assert not any(note.startswith(TOLD) for note in case.notes)
