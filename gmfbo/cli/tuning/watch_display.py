"""Display of a study on the terminal while another process writes it."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Self

from rich.console import Group
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from gmfbo.cli.console import gains_text
from gmfbo.cli.tuning.study_display import real_run_text
from gmfbo.plain_words import time_left

if TYPE_CHECKING:
    from rich.console import Console

    from gmfbo.reports.study.follower import StudyFollower
    from gmfbo.tuning.query.progress import Progress

_SOURCES = {"IS1": "real axis", "IS2": "twin", "IS3": "corrected twin"}


class WatchDisplay:
    """Status lines below a line for each real run; only the latter where output is no terminal.

    Parameters
    ----------
    console : Console
        Where to draw.
    follower : StudyFollower
        Of the study.
    """

    def __init__(self, console: Console, follower: StudyFollower) -> None:
        self._console, self._follower = console, follower
        self._newest: Progress | None = None
        self._news = time.monotonic()
        self._live = Live(console=console, auto_refresh=False, transient=True)

    def show(self, steps: list[Progress]) -> None:
        """Show the runs since the last call, or that there are none.

        Parameters
        ----------
        steps : list of Progress
            New runs, in order.
        """
        for step in steps:
            for told in (real_run_text(step), f"note: {step.note}" if step.note else ""):
                if told:
                    self._console.print(told, markup=False)
        if steps:
            self._newest, self._news = steps[-1], time.monotonic()
        if self._console.is_terminal:
            self._live.update(self._lines(), refresh=True)

    def _lines(self) -> Group | Text:
        file, step = self._follower.file, self._newest
        silent = f"{time_left(time.monotonic() - self._news)} since the last run"
        head = f"{file.name}: {file.method}, seed {file.seed}; {silent}"
        if step is None:
            return Text(f"{head}\nwaiting for the first runs")
        lines = Table.grid(padding=(0, 2))
        for name, told in self._facts(step).items():
            lines.add_row(name, told)
        return Group(Text(head), lines)

    def _facts(self, step: Progress) -> dict[str, Text | Table]:
        counts = dict.fromkeys(_SOURCES, 0)
        for run in self._follower.review.runs:
            counts[run.trial.source] += 1
        newest = f"run {step.trial}, {_SOURCES[step.source]}: {gains_text(step.gains)}"
        facts: dict[str, Text | Table] = {
            "done": self._done(step),
            "newest": Text(f"{newest}, objective {step.objective:.4f}"),
        }
        if step.best_gains is not None:
            best = f"{gains_text(step.best_gains)}, objective {step.best_objective:.4f}"
            facts[self._follower.review.best_words] = Text(best, style="bold")
        mismatch = "" if step.mismatch is None else f", mismatch {step.mismatch:.2f}"
        runs = f"{counts['IS1']} real, {counts['IS2']:,} of the twin, {counts['IS3']:,} corrected"
        facts["runs"] = Text(f"{runs}{mismatch}")
        return facts

    def _done(self, step: Progress) -> Table:
        most = self._follower.file.budget.is1_runs
        what, done, end = (
            ("queries", step.iteration, step.iterations)
            if most is None
            else ("real runs", step.is1_runs, most)
        )
        left = "" if step.seconds_left is None else f", about {time_left(step.seconds_left)} left"
        line = Table.grid(padding=(0, 1))
        bar = ProgressBar(total=end, completed=min(done, end), width=24)
        line.add_row(bar, Text(f"{done} of {end} {what}{left}"))
        return line

    def __enter__(self) -> Self:
        if self._console.is_terminal:
            self._live.start()
        return self

    def __exit__(self, *exception: object) -> None:
        if self._console.is_terminal:
            self._live.stop()
