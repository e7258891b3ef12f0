"""What a study may spend on its twin: runs, and seconds."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from gmfbo.recordings.store.trial import Trial
from gmfbo.tuning.study_file.study_sections import BudgetSection

EVENT = "twin_time"


@dataclass(eq=False)
class TwinBudget:
    """Budget of the twin's runs; used up, the study goes on with real runs alone.

    Attributes
    ----------
    section : BudgetSection
        Its `is2_runs` and `is2_seconds`.
    in_force : bool
        Whether the study was begun with such a budget.
    other_seconds : float
        [s] Time of twin runs that are no trials, such as those of an estimation.
    told : bool
        Whether this process has said that it is used up.
    """

    section: BudgetSection
    in_force: bool = True
    other_seconds: float = 0.0
    told: bool = False

    def seconds(self, trials: Iterable[Trial]) -> float:
        """[s] Time spent on the twin so far."""
        return self.other_seconds + sum(one.seconds for one in trials if one.source != "IS1")

    def used_up(self, trials: Iterable[Trial]) -> bool:
        """Whether no further run of the twin is allowed.

        Parameters
        ----------
        trials : iterable of Trial
            All runs of the study.
        """
        if not self.in_force:
            return False
        twin = [one for one in trials if one.source != "IS1"]
        most = self.section.is2_runs
        if most is not None and len(twin) >= most:
            return True
        return self.seconds(twin) >= self.section.is2_seconds

    def reason(self, trials: Iterable[Trial]) -> str:
        """Sentence that says that it is used up."""
        twin = [one for one in trials if one.source != "IS1"]
        return (
            f"the twin's budget is used up ({len(twin)} runs, {self.seconds(twin):.0f} s; [budget] "
            "is2_runs, is2_seconds): the study goes on with real runs alone"
        )
