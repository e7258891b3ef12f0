"""Progress of a study on a terminal; silent where output goes to a file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Self

from rich.progress import BarColumn, Progress, TextColumn

from gmfbo.cli.console import gains_text

if TYPE_CHECKING:
    from rich.console import Console

    from gmfbo.tuning.query import progress


class StudyDisplay:
    """Progress bar with the newest run, below a line for each real run.

    Parameters
    ----------
    console : Console
        Where to draw; nothing is drawn unless it is a terminal.
    most_real_runs : int or None
        Real runs at which the study ends; None where its queries are counted.
    """

    def __init__(self, console: Console, most_real_runs: int | None) -> None:
        self._console, self._most_real_runs = console, most_real_runs
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(bar_width=24),
            TextColumn("{task.fields[count]}"),
            TextColumn("{task.fields[state]}"),
            console=console,
            disable=not console.is_terminal,
            transient=True,
        )
        self._task = self._bar.add_task("initial data", total=None, count="", state="")

    def show(self, step: progress.Progress) -> None:
        """Show one finished run."""
        if step.phase == "news":
            self._bar.console.print(f"note: {step.note}", markup=False)
            return
        if not self._console.is_terminal:
            return
        if step.phase == "initial":
            done, most = step.initial_runs, step.most_initial_runs
            count = f"{done} of {most}"
            self._bar.update(
                self._task, completed=done, total=most, count=count, state=_state(step)
            )
        else:
            what, done, most = self._done(step)
            count = f"{done} of {most}"
            self._bar.update(
                self._task,
                description=what,
                completed=done,
                total=most,
                count=count,
                state=_state(step),
            )
        if told := real_run_text(step):
            self._bar.console.print(told)
        if step.note:
            self._bar.console.print(f"note: {step.note}")

    def _done(self, step: progress.Progress) -> tuple[str, int, int]:
        """Counted unit, number done, and number at which the study ends."""
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
    parts = [f"{step.source} {gains_text(step.gains)}"]
    if step.best_objective is not None:
        parts.append(f"best {step.best_objective:.4f}")
    if step.mismatch is not None:
        parts.append(f"mismatch {step.mismatch:.2f}")
    parts.append(f"cost {step.cost:.1f}")
    if step.seconds_left is not None:
        parts.append(f"{step.seconds_left:.0f} s left")
    return " | ".join(parts)
