"""Methods that propose on a twin corrected after each real run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gmfbo.retuning.missing_physics import complete
from gmfbo.retuning.refiner import PhysicsRefiner
from gmfbo.retuning.usual_physics import with_usual_physics
from gmfbo.sources.plants.source import Source
from gmfbo.sources.twin.twin import FmuTwin
from gmfbo.tuning.history.state import TuningState
from gmfbo.tuning.methods.gmfbo import CORRECTION, Gmfbo
from gmfbo.tuning.methods.identify_then_optimise import IdentifyThenOptimise
from gmfbo.tuning.query.method import CorrectionOptions, Method, Proposal
from gmfbo.tuning.twin.closer_look import LookingMethod
from gmfbo.tuning.twin.twin_version import TwinRefiner


@dataclass(frozen=True)
class OnCorrectedTwin:
    """Lets another method propose, on a twin that is corrected by the real runs.

    Attributes
    ----------
    name, summary, reference : str
        As of any method.
    searching : Method
        Method that proposes.
    refine : callable
        Makes a refiner of a twin, with a folder for files; None if it cannot be corrected.
    correction : CorrectionOptions
        How corrected runs are made.
    """

    name: str
    summary: str
    reference: str
    searching: Method
    refine: Callable[[FmuTwin, Path], TwinRefiner | None]
    correction: CorrectionOptions = CORRECTION

    def propose(self, state: TuningState, rng: np.random.Generator) -> Proposal | None:
        """Query the real axis where the corrected twin is most promising."""
        return self.searching.propose(state, rng)

    def promising(self, state: TuningState) -> NDArray[np.float64]:
        """Promising gains for a closer look; none where the method gives none."""
        if isinstance(self.searching, LookingMethod):
            return self.searching.promising(state)
        return np.empty((0, len(state.space)))

    def recommend(self, state: TuningState) -> tuple[NDArray[np.float64], float, float]:
        """Least expected cost among the gains where the twin was run."""
        return self.searching.recommend(state)

    def refiner(self, twin: Source, folder: Path) -> TwinRefiner | None:
        """Refiner of the twin; None where the twin is no FMU with a twin file."""
        return self.refine(twin, folder) if isinstance(twin, FmuTwin) else None


def _calibrate(twin: FmuTwin, folder: Path) -> TwinRefiner:
    return PhysicsRefiner(twin, folder)


def _complete(twin: FmuTwin, folder: Path) -> TwinRefiner:
    return PhysicsRefiner(twin, folder, with_usual_physics)


def _diagnose(twin: FmuTwin, folder: Path) -> TwinRefiner:
    return PhysicsRefiner(twin, folder, complete, asks_again=True)


_CALIBRATION = (
    "Kennedy and O'Hagan 2001, Bayesian calibration of computer models; on the corrected twin "
)

GMFBO_PHYSICS = OnCorrectedTwin(
    name="gmfbo_physics",
    summary="gmfbo on a twin whose parameters, tables and missing physics are estimated",
    reference=_CALIBRATION + "as gmfbo",
    searching=Gmfbo(),
    refine=_diagnose,
)

GMFBO_ESTIMATED = OnCorrectedTwin(
    name="gmfbo_estimated",
    summary="gmfbo on a twin whose parameters, tables, friction, load and delays are estimated",
    reference=_CALIBRATION + "as gmfbo",
    searching=Gmfbo(),
    refine=_complete,
)

GMFBO_CALIBRATED = OnCorrectedTwin(
    name="gmfbo_calibrated",
    summary="gmfbo_physics with nothing added: stated parameters and tables alone are estimated",
    reference=_CALIBRATION + "as gmfbo",
    searching=Gmfbo(),
    refine=_calibrate,
)

IDENTIFY_THEN_OPTIMISE = OnCorrectedTwin(
    name=IdentifyThenOptimise.name,
    summary=IdentifyThenOptimise.summary,
    reference=IdentifyThenOptimise.reference,
    searching=IdentifyThenOptimise(),
    refine=_complete,
)
