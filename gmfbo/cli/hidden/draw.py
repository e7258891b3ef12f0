"""Draw the demo's hidden physics from the user's seed, large enough to be found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gmfbo.cli.hidden.effects import EFFECTS, Rng, log_uniform

NOTHING = "nothing"
"""The axis equals its twin in all parameters."""

PARAMETERS = "parameters"
"""The axis differs from its twin in inertia and viscous friction only."""

_PLAIN_SHARE = 0.08  # of the draws hide nothing, and as many wrong parameters only


@dataclass(frozen=True)
class Draw:
    """Hidden physics of a plant.

    Attributes
    ----------
    seed : int
        The user's.
    hidden : str
        Name of an effect of the catalogue, `nothing` or `parameters`.
    plant : mapping of str to float
        Parameters of models/demo_axis.fmu that are not at their start values.
    """

    seed: int
    hidden: str
    plant: Mapping[str, float]


def draw(seed: int) -> Draw:
    """Draw what to hide.

    Parameters
    ----------
    seed : int
        Not negative; the same seed gives the same draw.

    Returns
    -------
    Draw
        An effect in 84 % of the seeds, each of `EFFECTS` as often; sizes log-uniform.
    """
    rng = np.random.default_rng((seed, 1))
    kind = rng.random()
    if kind < _PLAIN_SHARE:
        return Draw(seed, NOTHING, {})
    rigid = {"inertia": 0.01 * _factor(rng, 1.35), "viscous": 0.05 * _factor(rng, 1.5)}
    if kind < 2.0 * _PLAIN_SHARE:
        return Draw(seed, PARAMETERS, rigid)
    effect = EFFECTS[rng.integers(len(EFFECTS))]
    return Draw(seed, effect.name, {**rigid, **effect.draw(rng, rigid)})


def _factor(rng: Rng, most: float) -> float:
    """Factor that differs from one by at least 10 %, so that the twin is visibly wrong."""
    factor = log_uniform(rng, 1.1, most)
    return factor if rng.random() < 0.5 else 1.0 / factor
