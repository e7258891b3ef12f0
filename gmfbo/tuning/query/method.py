"""Interface of tuning methods: from all observations to the next query."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from gmfbo.tuning.history.state import TuningState


@dataclass(frozen=True, eq=False)
class Proposal:
    """The next query.

    Attributes
    ----------
    source : {"IS1", "IS2"}
        Source to query.
    point : ndarray, shape (d,)
        Gains scaled to the unit cube.
    mismatch : float or None
        Mismatch e of the twin that the method used, dimensionless.
    note : str
        Note for the user; usually empty.
    expected : tuple of float or None
        Predicted cost g of the real run, and its standard deviation; None where it is unknown.
    """

    source: Literal["IS1", "IS2"]
    point: NDArray[np.float64]
    mismatch: float | None = None
    note: str = ""
    expected: tuple[float, float] | None = None


@dataclass(frozen=True)
class Recommendation:
    """Gains at which a surrogate expects the least cost of the real axis, measured or not.

    Attributes
    ----------
    gains : mapping of str to float
        All gains by name [unit of the FMU parameter].
    mean, std : float
        Expected cost g of the real axis there, and its standard deviation.
    """

    gains: Mapping[str, float]
    mean: float
    std: float


@dataclass(frozen=True)
class CorrectionOptions:
    """Options of the twin runs around each real run, and of their correction (IS3).

    Attributes
    ----------
    memory : {"latest", "accumulate"}
        Real runs that the correction learns from: the last (Algorithm 1 as printed), or all.
    at_border : {"project", "reflect"}
        Draws outside the box are projected onto its faces (as printed), or folded back, so that
        they do not accumulate there.
    survey : int
        Runs of the twin over the box, made once before the first query.
    around_real : bool
        Whether to run the twin beside and around each real run; otherwise only the survey is made.
    corrected : bool
        Whether the runs around a real run are corrected by it (IS3); otherwise they stay runs of
        the twin (IS2), and no correction is fitted.
    closer : int
        Runs of the twin around the promising gains before each query, in each of two stages, for
        each tuned gain.
    """

    memory: Literal["latest", "accumulate"] = "latest"
    at_border: Literal["project", "reflect"] = "project"
    survey: int = 0
    around_real: bool = True
    corrected: bool = True
    closer: int = 0


class Method(Protocol):
    """Proposes queries; holds no state of its own, so that a study resumes exactly.

    Attributes
    ----------
    name : str
        Name in study files and tables.
    summary : str
        Description in a line.
    reference : str
        Publication.
    correction : CorrectionOptions or None
        Options of corrected runs; None if it uses none.
    """

    @property
    def name(self) -> str: ...
    @property
    def summary(self) -> str: ...
    @property
    def reference(self) -> str: ...
    @property
    def correction(self) -> CorrectionOptions | None: ...

    def propose(self, state: TuningState, rng: np.random.Generator) -> Proposal | None:
        """Propose the next query; None where the method needs no further query.

        Parameters
        ----------
        state : TuningState
            All observations, with the initial data complete.
        rng : numpy.random.Generator
            The only randomness allowed; derived from the study's seed and the step.
        """
        ...

    def recommend(self, state: TuningState) -> tuple[NDArray[np.float64], float, float]:
        """Point of the unit cube, shape (d,), with the least expected cost, its mean and std.

        Parameters
        ----------
        state : TuningState
            All observations.
        """
        ...


@runtime_checkable
class PublishedMethod(Protocol):
    """A method that prices a failed run, as its publication does; its runs are not ranked.

    Attributes
    ----------
    prices_failures : bool
        True.
    """

    @property
    def prices_failures(self) -> bool: ...
