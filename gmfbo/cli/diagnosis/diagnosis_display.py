"""Progress of a diagnosis on a terminal; silent where output goes to a file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Self

from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

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
    """

    def __init__(self, console: Console) -> None:
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
        done = min(max(share, 0.0), 1.0)
        # A text that is too long would shrink the bar.
        shown = stage if len(stage) <= self._room else f"{stage[: self._room - 3]}..."
        self._bar.update(self._task, description=shown, completed=done)

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(self, *exception: object) -> None:
        self._bar.stop()
