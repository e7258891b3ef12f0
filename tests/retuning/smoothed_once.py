"""A twin that is changed without any recording: the negative control of an estimate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from gmfbo.retuning.corrected_methods import GMFBO_CALIBRATED, OnCorrectedTwin
from gmfbo.retuning.unknowns import Unknowns
from gmfbo.sources.twin.twin import FmuTwin
from gmfbo.sources.twin.twin_at import TwinAt
from gmfbo.tuning.history.history import History
from gmfbo.tuning.twin.twin_version import TwinVersion


class SmoothingRefiner:
    """Smooths the tables of a twin before the first query, and then leaves it alone."""

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


def _smooth(twin: FmuTwin, folder: Path) -> SmoothingRefiner:
    return SmoothingRefiner(twin)


SMOOTHED_ONCE: OnCorrectedTwin = replace(GMFBO_CALIBRATED, name="smoothed_once", refine=_smooth)
