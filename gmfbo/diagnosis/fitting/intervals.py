"""Standard deviations and 95 % intervals of fitted parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.range_ends import ends_reached
from gmfbo.diagnosis.result.estimated import Combination, EstimatedParameter
from gmfbo.sources.twin.twin import FmuTwin

TWO_SIDED = 1.96
"""Standard deviations to each side that hold 95 % of a normal distribution."""

_SEEN = 0.15  # of a parameter's scale: a smaller standard deviation counts as identifiable
_UNSEEN_DIRECTION = 1e-6  # of the largest squared singular value
_UNEVEN = 0.1  # by which two powers of a combination may differ

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Spread:
    """Standard deviation and 95 % interval of each free parameter.

    Attributes
    ----------
    deviation, low, high : ndarray, shape (n,)
        [unit of the parameter]
    """

    deviation: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]


def estimated(
    fitted: Fitted, spread: Spread, twin: FmuTwin, ranges: Mapping[str, tuple[float, float]]
) -> dict[str, EstimatedParameter]:
    """Estimates of the twin's uncertain parameters; unidentifiable ones stay nominal.

    Parameters
    ----------
    fitted : Fitted
        Best model.
    spread : Spread
        Of the same fit.
    twin : FmuTwin
        For units, and for where its file states a range.
    ranges : mapping of str to (float, float)
        [FMU's unit] As the twin file states them; the fit's own are wider where these do not hold.
    """
    found = {}
    ends, hidden = ends_reached(fitted, ranges), _hidden_in_combinations(fitted)
    for i, uncertain in enumerate(fitted.hypothesis.setting.uncertain):
        if uncertain.name not in ranges:
            found[uncertain.name] = _freed(fitted, spread, twin, i)
            continue
        name, width = uncertain.name, uncertain.high - uncertain.low
        size = max(abs(uncertain.nominal), 0.3 * width)
        seen = name not in hidden and bool(spread.deviation[i] < _SEEN * size)
        value = float(fitted.x[i]) if seen else uncertain.nominal
        at = ends.get(name) if seen else None
        found[name] = EstimatedParameter(
            nominal=uncertain.nominal,
            value=value,
            unit=twin.binding.variables[name].variable.si_unit or "1",
            low=max(uncertain.low, float(spread.low[i])) if seen else uncertain.low,
            high=min(uncertain.high, float(spread.high[i])) if seen else uncertain.high,
            identifiable=seen,
            at_bound=at,
            bound=np.nan if at is None else ranges[name][at == "high"],
            stated="" if at is None else twin.place_of("uncertain", name),
        )
    return found


def _freed(fitted: Fitted, spread: Spread, twin: FmuTwin, place: int) -> EstimatedParameter:
    """Estimate of a parameter that the twin file holds fixed."""
    name = fitted.hypothesis.setting.uncertain[place].name
    return EstimatedParameter(
        nominal=twin.nominal(name),
        value=float(fitted.x[place]),
        unit=twin.binding.variables[name].variable.si_unit or "1",
        low=float(spread.low[place]),
        high=float(spread.high[place]),
        stated=twin.place_of("parameters", name),
        fixed=True,
    )


def combinations_of(fitted: Fitted) -> tuple[Combination, ...]:
    """Identifiable ratios of parameters that trade off against each other.

    Along an unseen direction n of the logarithms, ln p_i / n_i - ln p_k / n_k stays the same:
    each parameter of the direction is reported relative to the one that moves most.

    Parameters
    ----------
    fitted : Fitted
        Best model.
    """
    uncertain = fitted.hypothesis.setting.uncertain
    found = []
    directions, matrix = _unseen_directions(fitted)
    for direction in directions:
        pivot = int(np.argmax(np.abs(direction)))
        for i, share in enumerate(direction):
            power = share / direction[pivot]
            if i == pivot or abs(abs(power) - 1.0) > _UNEVEN:
                continue
            sign = "/" if power > 0.0 else "*"
            expression = f"{uncertain[i].name} {sign} {uncertain[pivot].name}"
            value = float(fitted.x[i] * fitted.x[pivot] ** (-1.0 if power > 0.0 else 1.0))
            inverse = np.linalg.pinv(matrix, rcond=10.0 * _UNSEEN_DIRECTION)
            ratio = np.zeros(len(uncertain))
            ratio[i], ratio[pivot] = 1.0, -1.0 if power > 0.0 else 1.0
            half = TWO_SIDED * value * float(np.sqrt(max(float(ratio @ inverse @ ratio), 0.0)))
            found.append(Combination(expression, value, value - half, value + half))
    return tuple(found)


def _hidden_in_combinations(fitted: Fitted) -> set[str]:
    """Parameters that data alone do not determine: a prior must not make them look known."""
    names = [uncertain.name for uncertain in fitted.hypothesis.setting.uncertain]
    hidden = set()
    for direction in _unseen_directions(fitted)[0]:
        least = _UNEVEN * float(np.max(np.abs(direction)))
        hidden |= {name for name, share in zip(names, direction, strict=True) if abs(share) > least}
    return hidden


def _unseen_directions(fitted: Fitted) -> tuple[list[Array], Array]:
    """Directions of the logarithms that the data do not see, and the information on all of them.

    Nothing is told of one parameter alone, or where a value is not positive.
    """
    count = len(fitted.hypothesis.setting.uncertain)
    values = fitted.x[:count]
    if count < 2 or np.any(values <= 0.0):
        return [], np.zeros((count, count))
    logs = [s[:count] * values[:, None] for s in fitted.sensitivity]
    matrix = np.asarray(sum(s @ s.T for s in logs))
    sizes, directions = np.linalg.eigh(matrix)
    least = min(_UNSEEN_DIRECTION * sizes[-1], _SEEN**-2)
    unseen = [d for size, d in zip(sizes, directions.T, strict=True) if size <= least]
    return unseen, matrix
