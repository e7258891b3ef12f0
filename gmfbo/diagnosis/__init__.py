"""Why simulation and recordings differ: where, which physics is missing, and the fit with it.

`diagnose` refits what is only roughly known, locates what is left, and names left-out physics
where recordings that had no part in the fit confirm it; `Diagnosis` is what it found.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gmfbo.diagnosis.diagnosis import Diagnosis

if TYPE_CHECKING:
    from gmfbo.diagnosis.engine import diagnose

__all__ = ["Diagnosis", "diagnose"]


def __getattr__(name: str) -> Any:
    # The engine needs the FMU's runner; to read a saved diagnosis does not.
    if name == "diagnose":
        from gmfbo.diagnosis.engine import diagnose

        return diagnose
    raise AttributeError(f"module 'gmfbo.diagnosis' has no attribute '{name}'")
