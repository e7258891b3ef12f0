"""Controller tuning with few runs of a real axis, and diagnosis of its twin.

The loop::

    real axis (IS1) ----> trajectories ----> error of the twin over the gains
        ^                                               |
        | next gains                                    v
    acquisition <--- surrogate <--- cost of the corrected twin <--- digital twin (IS2)

Public names load when first used, so that inspecting files needs no torch.
"""

from __future__ import annotations

import os
from importlib import import_module
from typing import TYPE_CHECKING, Any

from gmfbo.version import __version__ as __version__

# Two busy cores with two BLAS threads each run the same code up to 43 times slower, and the
# optimiser's path depends on the thread count; it must be set before NumPy is loaded.
for _variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")

if TYPE_CHECKING:
    from gmfbo.diagnosis import Check, Diagnosis, check, diagnose
    from gmfbo.recordings import Recording, Trajectory, step_reference
    from gmfbo.recordings.writing.writer import write_recording
    from gmfbo.reports.figures.notebook_figure import NotebookFigure
    from gmfbo.sources.fmu_file.models import models_folder
    from gmfbo.sources.twin.augmented_twin import AugmentedTwin
    from gmfbo.sources.twin.twin import FmuTwin
    from gmfbo.studies.campaign import campaign, compare
    from gmfbo.studies.comparison import Comparison
    from gmfbo.tuning.study.study import Study
    from gmfbo.tuning.tuner import Tuner

_HOMES = {
    "AugmentedTwin": "gmfbo.sources.twin.augmented_twin",
    "Check": "gmfbo.diagnosis",
    "Comparison": "gmfbo.studies.comparison",
    "Diagnosis": "gmfbo.diagnosis",
    "FmuTwin": "gmfbo.sources.twin.twin",
    "NotebookFigure": "gmfbo.reports.figures.notebook_figure",
    "Recording": "gmfbo.recordings",
    "Study": "gmfbo.tuning.study.study",
    "Trajectory": "gmfbo.recordings",
    "Tuner": "gmfbo.tuning.tuner",
    "campaign": "gmfbo.studies.campaign",
    "check": "gmfbo.diagnosis",
    "compare": "gmfbo.studies.campaign",
    "diagnose": "gmfbo.diagnosis",
    "models_folder": "gmfbo.sources.fmu_file.models",
    "step_reference": "gmfbo.recordings",
    "write_recording": "gmfbo.recordings.writing.writer",
}

_TAKE_METHODS = ("Comparison", "Study", "Tuner", "campaign", "compare")
"""Names that look a method up: those of `gmfbo.retuning` add themselves when it is imported."""

__all__ = [
    "AugmentedTwin",
    "Check",
    "Comparison",
    "Diagnosis",
    "FmuTwin",
    "NotebookFigure",
    "Recording",
    "Study",
    "Trajectory",
    "Tuner",
    "campaign",
    "check",
    "compare",
    "diagnose",
    "models_folder",
    "step_reference",
    "write_recording",
]


if not TYPE_CHECKING:  # a type checker that saw it would take any name for one of ours

    def __getattr__(name: str) -> Any:
        if name not in _HOMES:
            raise AttributeError(f"module 'gmfbo' has no attribute '{name}'")
        if name in _TAKE_METHODS:
            import_module("gmfbo.retuning")
        return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
