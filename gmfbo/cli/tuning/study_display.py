"""Progress of a study on a terminal; silent where output goes to a file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Self

from rich.progress import BarColumn, Progress, TextColumn

from gmfbo.cli.console import gains_text, whole_words
from gmfbo.plain_words import time_left

if TYPE_CHECKING:
    from rich.console import Console

    from gmfbo.tuning.query import progress

BAR = 24
MARK = len("...")


class StudyDisplay:
    """Progress bar with the newest run, below a line for each real run.

    Parameters
    ----------
    console : Console
        Where to draw; nothing is drawn unless it is a terminal.
    most_real_runs : int or None
        Real runs at which the study ends; None where its queries are counted.
    first_runs : int
        Runs of twin and axis before the first query.
    """

    def __init__(self, console: Console, most_real_runs: int | None, first_runs: int) -> None:
        self._console, self._most_real_runs = console, most_real_runs
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(bar_width=BAR),
            TextColumn("{task.fields[count]}"),
            TextColumn("{task.fields[state]}", markup=False),  # gains may hold brackets
            console=console,
            disable=not console.is_terminal,
            transient=True,
        )
        self._task = self._bar.add_task("initial data", total=first_runs, count="", state="")

    def show(self, step: progress.Progress) -> None:
        """Show one finished run."""
        if step.phase == "news":
            self._note(step.note)
            return
        if not self._console.is_terminal:
            return
        what, done, most = self._done(step)
        count = f"{done} of {most}"
        # A text that is too long would shrink the bar, or break the line.
        room = max(self._console.width - len(f"{what} {count} ") - BAR - 2, MARK)
        state = _state(step)
        self._bar.update(
            self._task,
            description=what,
            completed=done,
            total=most,
            count=count,
            state=state if len(state) <= room else f"{state[: room - MARK]}...",
        )
        if told := real_run_text(step):
            self._bar.console.print(told)
        if step.note:
            self._note(step.note)

    def _note(self, text: str) -> None:
        """Print a note; in whole words on a terminal, elsewhere in one line."""
        head = "note: "
        lines = whole_words(text, head) if self._console.is_terminal else [f"{head}{text}"]
        for line in lines:
            self._bar.console.print(line, markup=False)

    def _done(self, step: progress.Progress) -> tuple[str, int, int]:
        """Counted unit, number done, and number at which this part of the study ends."""
        if step.phase == "initial":
            return "initial data", step.initial_runs, step.most_initial_runs
        if self._most_real_runs is not None:
            return "real runs", step.is1_runs, self._most_real_runs
        return "queries", step.iteration, step.iterations

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(self, *exception: object) -> None:
        self._bar.stop()


def real_run_text(step: progress.Progress) -> str:
    """Describe a real run in a line; empty for other runs."""
    if step.source != "IS1" or step.phase not in ("initial", "query"):
        return ""
    ended = "" if step.status == "ok" else f" ({step.status})"
    return (
        f"real run {step.is1_runs}: {gains_text(step.gains)}, objective {step.objective:.4f}{ended}"
    )


def _state(step: progress.Progress) -> str:
    parts = []
    if step.seconds_left is not None:
        parts.append(f"{time_left(step.seconds_left)} left")
    if step.best_objective is not None:
        parts.append(f"best {step.best_objective:.4f}")
    if step.mismatch is not None:
        parts.append(f"mismatch {step.mismatch:.2f}")
    parts.append(f"{step.source} {gains_text(step.gains)}")
    return " | ".join(parts)
