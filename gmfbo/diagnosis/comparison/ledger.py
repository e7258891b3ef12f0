"""Fitted hypotheses, the noise under which they compete, and the beliefs in them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.heard_noise import HeardNoise
from gmfbo.diagnosis.comparison.moves import Response
from gmfbo.diagnosis.comparison.noise.places import Levels
from gmfbo.diagnosis.comparison.numbers import named_log_odds
from gmfbo.diagnosis.comparison.port_kernels import PortKernels
from gmfbo.diagnosis.comparison.simulation_errors import SimulationErrors
from gmfbo.diagnosis.comparison.whitener import Whitening

Array = NDArray[np.float64]

_RIVALS = 3  # at a time, that hear their own noise


@dataclass(frozen=True, eq=False)
class Ledger:
    """Fitted hypotheses and the noise under which they compete.

    Attributes
    ----------
    rows : mapping of frozenset to Fitted
        By what they add to the twin.
    kernels : PortKernels
        Paths from the ports to the signals.
    levels : Levels
        Of noise, and of the inadequacy that all rows share.
    whitening : Whitening
        By these levels.
    opened : Levels
        Those about the twin without any element.
    errors : SimulationErrors
        Of the simulation about the row whose levels they are.
    noise : HeardNoise, or None
        That the controller read, as the best row tells it; rows are fitted under it.
    own_noise : mapping of frozenset to HeardNoise
        By row, that it tells itself: it is fitted under this instead.
    responses : tuple of Response
        Of all elements about the twin without them.
    """

    rows: dict[frozenset[str], Fitted]
    kernels: PortKernels
    levels: Levels
    whitening: Whitening
    opened: Levels
    errors: SimulationErrors
    noise: HeardNoise | None = None
    own_noise: Mapping[frozenset[str], HeardNoise] = field(default_factory=dict)
    responses: tuple[Response, ...] = ()

    def noise_of(self, elements: frozenset[str]) -> HeardNoise | None:
        """Noise under which a row is fitted."""
        return self.own_noise.get(elements, self.noise)


@dataclass(frozen=True, eq=False)
class Scored:
    """Beliefs in the rows of a ledger.

    Attributes
    ----------
    elements : tuple of frozenset
        Of each row.
    log_evidences : ndarray, shape (n_rows, n_weightings)
        With the prior of the hypothesis.
    beliefs : ndarray, shape (n_rows,)
        Mean over the weightings.
    sizes : ndarray, shape (n_rows,)
        [FMU's unit of the torque port] Of the inadequacy beside each row.
    """

    elements: tuple[frozenset[str], ...]
    log_evidences: Array
    beliefs: Array
    sizes: Array

    def size_beside(self, row: frozenset[str]) -> float:
        """[FMU's unit of the torque port] Of the inadequacy beside a row.

        Of one that was not scored, that beside the largest row that it holds.
        """
        held = [elements for elements in self.elements if elements <= row]
        return float(self.sizes[self.elements.index(max(held, key=len))])

    @property
    def best(self) -> frozenset[str]:
        """Row of the largest belief."""
        return self.elements[int(np.argmax(self.log_evidences.mean(1)))]

    @property
    def ahead(self) -> set[frozenset[str]]:
        """The best row, and larger ones that may be as good: what they lack shows beside them."""
        logs = self.log_evidences.mean(1)
        near = logs > logs.max() - named_log_odds()
        larger = {
            elements
            for elements, is_near in zip(self.elements, near, strict=True)
            if is_near and len(elements) > len(self.best)
        }
        return {self.best} | larger

    def rivals_to_hear(self, ledger: Ledger) -> list[frozenset[str]]:
        """Rows that come next, whose laws meet the noise otherwise than linear ones do.

        Noise is told by what a row leaves: it makes up for what the row lacks, and speaks against
        the laws of all others. So these hear their own.

        Parameters
        ----------
        ledger : Ledger
            With the rows, and the noise that some of them have heard.
        """
        order = [self.elements[i] for i in np.argsort(-self.log_evidences.mean(1))]
        found = [
            elements
            for elements in order
            if elements != self.best
            and elements not in ledger.own_noise
            and not ledger.rows[elements].hypothesis.is_linear
        ]
        return found[:_RIVALS]
