"""The bar of a running study: it has an end from its first run on, and fits the terminal."""

from __future__ import annotations

import io
import re
from typing import Any

import pytest
from rich.console import Console

from gmfbo.cli.tuning.study_display import StudyDisplay
from gmfbo.tuning.query.progress import Progress

LONG = {f"controller.a_rather_long_name.gain_{k}": 12.345 for k in range(6)}


def step(**given: Any) -> Progress:
    usual = {
        "phase": "query", "iteration": 3, "iterations": 20, "is1_runs": 4, "trial": 17,
        "source": "IS2", "gains": LONG, "objective": 0.5, "status": "ok", "best_objective": 0.25,
        "best_gains": LONG, "mismatch": 0.5, "cost": 4.0, "seconds": 1.0, "seconds_left": 4310.0,
    }  # fmt: skip
    return Progress(**{**usual, **given})


def lines(*steps: Progress, width: int = 80) -> list[str]:
    """What stood on the terminal, without its codes."""
    drawn = io.StringIO()
    screen = Console(file=drawn, force_terminal=True, width=width, legacy_windows=False)
    with StudyDisplay(screen, None, 14) as display:
        for one in steps:
            display.show(one)
    text = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", drawn.getvalue())
    return [line for line in re.split(r"[\r\n]+", text) if line.strip()]


@pytest.mark.parametrize("width", [60, 80, 120])
def test_no_line_is_wider_than_the_terminal(width: int) -> None:
    shown = lines(step(phase="initial", trial=3), step(), width=width)
    assert max(map(len, shown)) <= width
    assert any("3 of 20" in line for line in shown)


def test_initial_runs_of_the_twin_are_counted_against_their_number() -> None:
    counted = {"phase": "initial", "most_initial_runs": 14}
    first = lines(step(**counted, initial_runs=3, seconds_left=None, best_objective=None))
    assert any("initial data" in line and "3 of 14" in line for line in first)
    # Runs beside the first real ones have numbers of their own.
    beyond = lines(step(**counted, initial_runs=14, trial=40, source="IS1", gains={"kp": 1.0}))
    assert any("14 of 14" in line for line in beyond)


def test_the_time_left_is_read_at_a_glance_and_never_cut_off() -> None:
    assert any("72 min left" in line for line in lines(step()))


def test_control_gains_that_fit_are_shown_whole() -> None:
    shown = lines(step(gains={"kp": 80.0}, seconds_left=None, mismatch=None))
    assert any("IS2 kp = 80" in line for line in shown)
    assert not any("..." in line for line in shown)


def test_a_note_is_whole_words_and_its_own_lines_stay_lines() -> None:
    told = "the twin was corrected: " + "coulomb friction, " * 8 + "\n  inertia: 0.01 -> 0.0105"
    shown = lines(step(phase="news", note=told))
    assert max(map(len, shown)) <= 80
    assert "        inertia: 0.01 -> 0.0105" in shown
    notes = " ".join(line for line in shown if "initial data" not in line)
    assert " ".join(notes.split()) == "note: " + " ".join(told.split())
