"""Held-out errors of what was told, over those of the true law fitted to the same recordings.

The yardstick is the plant itself with its values refitted, simulated as a twin is: without noise,
in closed loop from the reference. The engine's own fit with the right name would measure the
library's formula, and share the faults of the fit that is judged.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tests.blind.draw.fit_of_the_true_law import TrueLaw
from tests.blind.draw.noise_of_a_case import driven
from tests.blind.draw.remade import Columns
from tests.blind.truth import Vector


def errors_of(
    law: TrueLaw, recorded: Columns, x: Vector, held_out: Sequence[int]
) -> dict[str, float]:
    """Errors of the plant at some values on held-out recordings, over each signal's range.

    Parameters
    ----------
    law : TrueLaw
        The plant.
    recorded : list of ndarray, shape (rows, 2) each
        All recordings.
    x : ndarray
        Its free values.
    held_out : sequence of int
        Recordings that are scored, all their rows.

    Returns
    -------
    dict of str to float
        By signal, as `fit.signals` of a diagnosis has them; the position alone of an open loop,
        which runs from the first recorded position under the recorded command.
    """
    case, values = law.case, law.free.at(x)
    own = [recorded[k] for k in held_out]
    if case.machine.is_open_loop:
        return {"position": nrmse([one[:, 0] for one in own], [driven(values, one) for one in own])}
    runs = case.clean(values, held_out)
    return {
        name: nrmse([one[:, k] for one in own], [run[:, k] for run in runs])
        for k, name in enumerate(("position", case.machine.command_name))
    }


def nrmse(recorded: Sequence[Vector], simulated: Sequence[Vector]) -> float:
    """Root mean square error over the range of what was recorded, over all rows."""
    y, model = np.concatenate(recorded), np.concatenate(simulated)
    return float(np.sqrt(np.mean((y - model) ** 2)) / np.ptp(y))


def told_errors(diagnosis: Mapping[str, Any], is_open_loop: bool) -> dict[str, float]:
    """Held-out errors of what was told; of the refitted twin where nothing was.

    Parameters
    ----------
    diagnosis : mapping
        Content of diagnosis.json.
    is_open_loop : bool
        Whole runs that nothing corrects are compared then.
    """
    found = {}
    for name, errors in diagnosis["fit"]["signals"].items():
        own = errors["free_run"] if is_open_loop else errors
        if own:
            augmented = own["augmented"]
            found[name] = own["parameters_only"] if augmented is None else augmented
    return found


def joint_ratio(
    told: Mapping[str, float], true: Mapping[str, float], noise: Mapping[str, float]
) -> float:
    """Ratio of two models' errors over all signals, each signal in units of its noise.

    sqrt(sum (told / noise)^2 / sum (true / noise)^2)

    Parameters
    ----------
    told, true, noise : mapping of str to float
        By signal, over its range; signals that both models have count.
    """
    shared = sorted(told.keys() & true.keys())
    size = [np.linalg.norm([own[s] / noise[s] for s in shared]) for own in (told, true)]
    return float(size[0] / size[1])
