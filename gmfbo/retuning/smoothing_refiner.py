"""Smooth the twin's tables once without recordings: a baseline for calibration."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gmfbo.retuning.twin_at import TwinAt
from gmfbo.retuning.unknowns import Unknowns
from gmfbo.sources.twin.twin import FmuTwin
from gmfbo.tuning.history.history import History
from gmfbo.tuning.twin.twin_version import TwinVersion


class SmoothingRefiner:
    """Smooths the tables of a twin before the first query, and then leaves it alone.

    Parameters
    ----------
    twin : FmuTwin
        As the study file names it, with tables.
    """

    def __init__(self, twin: FmuTwin) -> None:
        self._twin, self._done = twin, False

    def revise(self, history: History) -> TwinVersion | None:
        """Return the smooth twin, once."""
        return None if self._done else self._smooth()

    def restore(self, event: Mapping[str, Any]) -> TwinVersion:
        """Return the smooth twin again."""
        return self._smooth()

    def close(self) -> None:
        """Do nothing."""

    def _smooth(self) -> TwinVersion:
        self._done = True
        unknowns = Unknowns.of(self._twin)
        source = TwinAt(self._twin, unknowns.settings(unknowns.smoothed))
        return TwinVersion(1, source, "its tables were smoothed")
