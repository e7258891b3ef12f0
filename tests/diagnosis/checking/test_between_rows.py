"""Inputs that the twin file leaves open run between slow rows as makes the bare twin likelier."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.case.open_case import open_case
from gmfbo.diagnosis.checking.between_rows import (
    driven_as_likelier,
    note_of_straight,
    straight_inputs,
)
from gmfbo.errors import SimulationError
from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin.twin import FmuTwin
from tests.diagnosis.short_recordings import BENCH

SLOW = 20  # steps of the twin from row to row

Run = Callable[[NDArray[np.float64]], NDArray[np.float64]]


def to_and_fro(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """[A] Two tones."""
    moved: NDArray[np.float64] = 0.4 * np.sin(9.0 * t) + 0.2 * np.sin(23.0 * t + 1.0)
    return moved


def held(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """[A] The same, computed every 20 ms and held."""
    return to_and_fro(0.02 * np.floor(t / 0.02 + 1e-9))


def slow_rows(run: Run) -> list[Recording]:
    """A recording of which every 20th row was written."""
    made = BENCH.recordings({}, (run,), seconds=2.4)
    return [
        dataclasses.replace(
            own,
            time=own.time[::SLOW],
            signals={name: column[::SLOW] for name, column in own.signals.items()},
            written_by="",
        )
        for own in made
    ]


@pytest.mark.parametrize(("run", "linear"), [(to_and_fro, True), (held, False)])
def test_a_current_that_ran_on_is_driven_straight_and_one_that_was_held_is_held(
    run: Run, linear: bool
) -> None:
    recordings = slow_rows(run)

    def opened(twin: FmuTwin, own: Sequence[Recording]) -> Case:
        return open_case(twin, own, seed=0, jobs=1)

    driven = driven_as_likelier(opened(BENCH.twin(), recordings), recordings, opened)
    case = driven.case
    assert driven.late == ()
    assert list(driven.recordings) == recordings
    try:
        told = straight_inputs(case.twin, BENCH.twin())
        assert told == (["current"] if linear else [])
        assert [note.split(":")[0] for note in note_of_straight(told)] == told
        assert case.base.parameters["inertia"] == pytest.approx(0.0052, rel=0.02)
    finally:
        case.simulations.close()


def test_a_twin_that_does_not_run_when_driven_straight_is_held() -> None:
    recordings = slow_rows(to_and_fro)

    def fails(other: FmuTwin, own: Sequence[Recording]) -> Case:
        raise SimulationError("no such step")

    case = open_case(BENCH.twin(), recordings, seed=0, jobs=1)
    assert driven_as_likelier(case, recordings, fails).case is case
    assert case.simulations.run([case.base.hypothesis.point(case.base.x)])[0][0].finite
    case.simulations.close()


def test_rows_as_fast_as_the_twin_and_inputs_that_are_stated_are_left_as_they_are() -> None:
    twin = BENCH.twin()
    fast = BENCH.recordings({}, (held,))

    def never(other: FmuTwin, own: Sequence[Recording]) -> Case:
        raise AssertionError("nothing is open")

    case = open_case(twin, fast, seed=0, jobs=1)
    assert driven_as_likelier(case, fast, never).case is case
    case.simulations.close()
    stated = {"current": twin.file.inputs["current"].model_copy(update={"interpolation": "hold"})}
    told = twin.with_file(twin.file.model_copy(update={"inputs": stated}))
    slow = slow_rows(held)
    case = open_case(told, slow, seed=0, jobs=1)
    assert driven_as_likelier(case, slow, never).case is case
    case.simulations.close()


def test_a_current_that_was_logged_a_row_late_is_taken_a_row_sooner() -> None:
    """A row late is one that holds what the row before it held."""
    known = slow_rows(to_and_fro)
    recordings = [
        dataclasses.replace(
            own, signals={**own.signals, "current": np.roll(own.signals["current"], 1)}
        )
        for own in known
    ]

    def opened(twin: FmuTwin, own: Sequence[Recording]) -> Case:
        return open_case(twin, own, seed=0, jobs=1)

    driven = driven_as_likelier(opened(BENCH.twin(), recordings), recordings, opened)
    try:
        assert driven.late == ("current",)
        np.testing.assert_array_equal(
            driven.recordings[0].signals["current"][:-1], known[0].signals["current"][:-1]
        )
        assert driven.case.base.parameters["inertia"] == pytest.approx(0.0052, rel=0.02)
        assert len(note_of_straight(["current"], driven.late)) == 2
    finally:
        driven.case.simulations.close()
