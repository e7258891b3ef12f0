"""Diagnose a digital twin: where it differs from recordings, and what it lacks.

`diagnose` refits what is only roughly known, compares what could be missing by one score, and
names what held-out recordings do not contradict; `Diagnosis` is what it found. `check`
looks at recordings first, fits nothing, and gives a `Check`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gmfbo.diagnosis.checking.result import Check
from gmfbo.diagnosis.diagnosis import Diagnosis

if TYPE_CHECKING:
    from gmfbo.diagnosis.checking.check import check
    from gmfbo.diagnosis.engine import diagnose

__all__ = ["Check", "Diagnosis", "check", "diagnose"]


if not TYPE_CHECKING:  # a type checker that saw it would take any name for one of ours

    def __getattr__(name: str) -> Any:
        # They need the FMU's runner; to read a saved diagnosis does not.
        if name == "check":
            from gmfbo.diagnosis.checking.check import check

            return check
        if name == "diagnose":
            from gmfbo.diagnosis.engine import diagnose

            return diagnose
        raise AttributeError(f"module 'gmfbo.diagnosis' has no attribute '{name}'")
