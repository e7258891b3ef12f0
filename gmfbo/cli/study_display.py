"""Progress of a study on a terminal; silent where output goes to a file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Self

from rich.progress import BarColumn, Progress, TextColumn

from gmfbo.cli.console import gains_text

if TYPE_CHECKING:
    from rich.console import Console

    from gmfbo.tuning import progress


class StudyDisplay:
    """A bar with the newest run below a line for each real run.

    Parameters
    ----------
    console : Console
        Where to draw; nothing is drawn unless it is a terminal.
    """

    def __init__(self, console: Console) -> None:
        self._console = console
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(bar_width=24),
            TextColumn("{task.completed:.0f}/{task.total:.0f}"),
            TextColumn("{task.fields[state]}"),
            console=console,
            disable=not console.is_terminal,
            transient=True,
        )
        self._task = self._bar.add_task("initial data", total=1, state="")

    def show(self, step: progress.Progress) -> None:
        """Show one finished run."""
        if not self._console.is_terminal:
            return
        self._bar.update(
            self._task,
            description="initial data" if step.phase == "initial" else "queries",
            completed=step.iteration,
            total=max(step.iterations, 1),
            state=_state(step),
        )
        if step.source == "IS1" and step.phase in ("initial", "query"):
            self._bar.console.print(
                f"real run {step.is1_runs}: {gains_text(step.gains)}, "
                f"objective {step.objective:.4f}"
                + ("" if step.status == "ok" else f" ({step.status})")
            )
        if step.note:
            self._bar.console.print(f"note: {step.note}")

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(self, *exception: object) -> None:
        self._bar.stop()


def _state(step: progress.Progress) -> str:
    parts = [f"{step.source} {gains_text(step.gains)}"]
    if step.best_objective is not None:
        parts.append(f"best {step.best_objective:.4f}")
    if step.mismatch is not None:
        parts.append(f"mismatch {step.mismatch:.2f}")
    parts.append(f"cost {step.cost:.1f}")
    if step.seconds_left is not None:
        parts.append(f"{step.seconds_left:.0f} s left")
    return " | ".join(parts)
