"""Keep a study's twin corrected, where its method has a refiner."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Any, Self

from gmfbo.tuning.history.history import History
from gmfbo.tuning.history.twin_budget import EVENT as TIME_EVENT
from gmfbo.tuning.query.method import Method
from gmfbo.tuning.twin.learned import learned_lines
from gmfbo.tuning.twin.twin_runs import TwinRuns
from gmfbo.tuning.twin.twin_version import RefiningMethod, TwinRefiner, TwinVersion
from gmfbo.tuning.watch import Watch

EVENT = "twin_version"

WORTH_LOGGING_S = 1.0
"""[s] Time of an estimation that counts in the twin's budget of, by default, half an hour."""


@dataclass(eq=False)
class TwinCorrections:
    """The versions of a study's twin.

    Attributes
    ----------
    runs : TwinRuns
        Runs of the present twin.
    refiner : TwinRefiner or None
        None where the twin stays as the study file names it.
    seen : int
        Number of the last real run that the refiner was shown.
    """

    runs: TwinRuns
    refiner: TwinRefiner | None
    seen: int = 0

    @classmethod
    def begin(cls, method: Method, runs: TwinRuns) -> Self:
        """Restore the latest version of a study's twin.

        Parameters
        ----------
        method : Method
            May have a refiner of the twin.
        runs : TwinRuns
            Runs of the twin that the study file names.
        """
        if not isinstance(method, RefiningMethod):
            return cls(runs, None)
        folder = runs.history.store.location / "twins"
        corrections = cls(runs, method.refiner(runs.source, folder))
        logged = corrections._logged()
        if corrections.refiner is not None and logged:
            corrections.seen = logged[-1]["after"]
            corrections._use(corrections.refiner.restore(logged[-1]))
        return corrections

    @property
    def reasons(self) -> tuple[str, ...]:
        """Reasons of the corrections, in order."""
        return tuple(event["reason"] for event in self._logged())

    @property
    def learned(self) -> tuple[str, ...]:
        """What the latest version has learned, in lines; none before the first."""
        logged = self._logged()
        return learned_lines(logged[-1]) if logged else ()

    @property
    def just_made(self) -> bool:
        """Whether the newest real run led to a new version of the twin."""
        logged, real = self._logged(), self.runs.history.of("IS1")
        return bool(logged and real and logged[-1]["after"] == real[-1].number)

    def follow(self, watch: Watch) -> TwinRuns:
        """Show the newest real run to the refiner; after a correction repeat the twin's runs."""
        history: History = self.runs.history
        real = history.of("IS1")
        if self.refiner is None or len(real) < history.study.budget.initial_is1:
            return self.runs
        if history.twin_used_up:
            return self.runs
        if real[-1].number != self.seen:
            self.seen = real[-1].number
            began = time.perf_counter()
            version = self.refiner.revise(history)
            self._spend(time.perf_counter() - began)
            if version is not None:
                history.store.log(
                    EVENT,
                    version=version.number,
                    after=self.seen,
                    twin=version.source.content_hash,
                    reason=version.reason,
                    **version.details,
                )
                self._use(version)
                news = f"the twin was corrected: {version.reason}"
                told = (news, *learned_lines(version.details))
                watch.tell("twin", real[-1], None, "\n      ".join(told))
        if history.twin is not None:
            self.runs.renew()
        return self.runs

    def _spend(self, seconds: float) -> None:
        """Log time of an estimation that counts in the twin's budget."""
        history = self.runs.history
        if history.twin_budget.in_force and seconds >= WORTH_LOGGING_S:
            history.store.log(TIME_EVENT, seconds=round(seconds, 3))
            history.twin_budget.other_seconds += seconds

    def close(self) -> None:
        """Give back what was opened to correct the twin."""
        if self.refiner is not None:
            self.refiner.close()

    def _logged(self) -> list[dict[str, Any]]:
        events = self.runs.history.store.events()
        return [event for event in events if event["event"] == EVENT]

    def _use(self, version: TwinVersion) -> None:
        self.runs = replace(self.runs, source=version.source)
        self.runs.history.twin = version.source.content_hash
