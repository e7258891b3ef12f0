"""Progress of a diagnosis: a bar on a terminal, elsewhere a line for each stage that ended."""

from __future__ import annotations

from typing import TYPE_CHECKING, Self

import typer
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

from gmfbo.diagnosis.stage_times import StageTimes

if TYPE_CHECKING:
    from rich.console import Console

BAR = 24
TAKEN = BAR + len(" 100% 0:00:00 ") + 1  # columns of all but the words


class DiagnosisDisplay:
    """One line: progress, time so far, and the present stage.

    Parameters
    ----------
    console : Console
        Where to draw; nothing is drawn unless it is a terminal.
    lines : bool
        Whether, without a terminal, each stage that ended is a line on standard error with its
        seconds: for what takes minutes, so that a log shows how far it is.
    """

    def __init__(self, console: Console, *, lines: bool = False) -> None:
        told = lines and not console.is_terminal
        self._stages = StageTimes(_silent, "", _line) if told else None
        self._bar = Progress(
            BarColumn(bar_width=BAR),
            TaskProgressColumn(),
            TimeElapsedColumn(),
            TextColumn("{task.description}", markup=False),  # may hold brackets
            console=console,
            disable=not console.is_terminal,
            transient=True,
        )
        self._room = max(console.width - TAKEN, 10)
        self._task = self._bar.add_task("reading", total=1.0)

    def show(self, stage: str, share: float) -> None:
        """Show a stage, in words, and the share done, 0 to 1."""
        if self._stages is not None:
            self._stages(stage, share)
            return
        done = min(max(share, 0.0), 1.0)
        # A text that is too long would shrink the bar.
        shown = stage if len(stage) <= self._room else f"{stage[: self._room - 3]}..."
        self._bar.update(self._task, description=shown, completed=done)

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(self, *exception: object) -> None:
        self._bar.stop()


def _silent(stage: str, share: float) -> None:
    """Nothing is told at the start of a stage: what fails in it stays one line."""


def _line(stage: str, seconds: float) -> None:
    if stage:
        typer.echo(f"{stage}: {seconds:.1f} s", err=True)
