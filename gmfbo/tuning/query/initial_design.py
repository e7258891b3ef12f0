"""Initial design: the same first runs for every method at the same seed."""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from gmfbo.space import GainSpace


class Stream(IntEnum):
    """Purpose of a random stream; part of its seed, so that no two streams are equal."""

    INITIAL_IS1 = 0
    INITIAL_IS2 = 1
    IS3 = 2
    PROPOSAL = 3
    SURVEY = 4
    CLOSER_LOOK = 5
    NOISE = 6
    BELIEVED_TWIN = 7


def stream(seed: int, purpose: Stream, *numbers: int) -> np.random.Generator:
    """Random stream of one step of one study.

    It depends on its arguments alone, so that a resumed study draws the same numbers.

    Parameters
    ----------
    seed : int
        Of the study.
    purpose : Stream
        Purpose of the stream.
    *numbers : int
        Number of the trial, and of the draw within it.
    """
    return np.random.default_rng([seed, int(purpose), *numbers])


def initial_points(
    space: GainSpace, seed: int, purpose: Stream, count: int, further: int = 0
) -> NDArray[np.float64]:
    """Latin hypercube of the unit cube, shape (count, d).

    Parameters
    ----------
    space : GainSpace
        Box of the tuned gains.
    seed : int
        Of the study.
    purpose : Stream
        `INITIAL_IS1`, `INITIAL_IS2` or `SURVEY`.
    count : int
        Number of points.
    further : int
        Number of the hypercubes before this one.
    """
    numbers = (further,) if further else ()
    return space.to_unit(space.latin_hypercube(count, stream(seed, purpose, *numbers)))
