"""What recordings show at the torque port beside the named law that stands for it.

A curve without a name is fitted about the twin with its refitted parameters and the named law: what
that twin leaves, as a free function of the law's state, is put on top of the law (component plus
residual, Ezekiel 1924). A law of the right shape lies within the band of that curve.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.comparison.numbers import MOST
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.diagnosis.fitting.intervals import TWO_SIDED
from gmfbo.diagnosis.fitting.linear_left_out import normal_equations, solve_weakly_bound
from gmfbo.diagnosis.fitting.misfit import chi2
from gmfbo.diagnosis.outside.state_features import (
    Family,
    of_folded_position,
    of_position,
    of_velocity,
)
from gmfbo.diagnosis.result.whereabouts import Shape
from gmfbo.diagnosis.runs.measured_excitation import states_of
from gmfbo.diagnosis.screening.port_response import PortResponse
from gmfbo.diagnosis.screening.seen_from_port import whitened_columns
from gmfbo.physics import States, Units

Array = NDArray[np.float64]

_BINS = 120  # of the drawn law: a point every five pixels of the chart
_NEAREST = 9  # samples whose mean is the law at a knot: few, since a law may jump beside it


def inferred_beside_law(
    case: Case, augmented: Fitted, response: PortResponse | None, units: Units
) -> Shape | None:
    """Infer the torque that acts at the port, and draw the named law with it.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    augmented : Fitted
        The refitted twin with the named physics.
    response : PortResponse or None
        Answer of the outputs to a torque.
    units : Units
        Of port and states.

    Returns
    -------
    Shape or None
        None where no law acts at the torque port, or where what acts there is no function of the
        velocity or the position.
    """
    law = next((e for e in augmented.hypothesis.effects if e.law.port == "torque"), None)
    if law is None or response is None or response.port != "torque":
        return None
    records = case.simulations.records
    states = [states_of(run, r) for run, r in zip(augmented.simulated, records, strict=True)]
    acting = [np.asarray(run.response.ports["torque"]) for run in augmented.simulated]
    family = _family(law, states)
    if family is None:
        return None
    along = np.concatenate([_state(family, law, s) for s in states])
    x, y, share = _means(along, np.concatenate(acting))
    if share < MOST:
        return None  # the law depends on more than this state: a curve over it would mislead
    change, half = _left(case, augmented, response, family)
    values = _at_knots(family.knots, along, np.concatenate(acting)) + change
    return Shape(
        port="torque",
        against=family.against,
        x=_numbers(family.knots),
        y=_numbers(values),
        y_low=_numbers(values - half),
        y_high=_numbers(values + half),
        unit_x=units.velocity if family.unit == "velocity" else units.position,
        unit_y=units.torque,
        law=law.effect,
        law_x=_numbers(x),
        law_y=_numbers(y),
    )


def _period(law: Candidate) -> float | None:
    """Length after which a law over the position repeats [unit of the position]."""
    waves = [v for n, v in law.values.items() if n in ("wavenumber", "wavenumber_1") and v > 0.0]
    return 2.0 * np.pi / waves[0] if waves else None


def _family(law: Candidate, states: Sequence[States]) -> Family | None:
    """Free function over the state in which the law acts; None for other states."""
    if law.only is not None:
        return None
    if law.law.region_state == "velocity":
        return of_velocity(states)
    if law.law.region_state != "position":
        return None
    period = _period(law)
    return of_position(states) if period is None else of_folded_position(states, period)


def _state(family: Family, law: Candidate, states: States) -> Array:
    if family.unit == "velocity":
        return states.velocity
    period = _period(law)
    return states.position if period is None else np.mod(states.position, period)


def _means(state: Array, torque: Array) -> tuple[Array, Array, float]:
    """Mean torque over bins of the state, and the share of its square that they explain."""
    edges = np.linspace(state.min(), state.max(), _BINS + 1)
    place = np.clip(np.searchsorted(edges, state, "right") - 1, 0, _BINS - 1)
    count = np.bincount(place, minlength=_BINS)
    seen = count > 0
    means = np.bincount(place, torque, _BINS)[seen] / count[seen]
    left = torque - (np.bincount(place, torque, _BINS) / np.maximum(count, 1))[place]
    square = float(torque @ torque)
    share = 1.0 - float(left @ left) / square if square > 0.0 else 0.0
    return (0.5 * (edges[1:] + edges[:-1]))[seen], means, share


def _at_knots(knots: Array, state: Array, torque: Array) -> Array:
    """Torque at each knot: the mean over the samples whose state is nearest."""
    nearest = [np.argsort(np.abs(state - knot))[:_NEAREST] for knot in knots]
    return np.array([torque[rows].mean() for rows in nearest])


def _left(
    case: Case, augmented: Fitted, response: PortResponse, family: Family
) -> tuple[Array, Array]:
    """What the twin leaves, at the knots, and half its 95 % band [unit of the torque]."""
    model = augmented.measured_by(case.plain)
    columns = whitened_columns(case.plain, response, family.columns)
    # A knot that the motion hardly reaches is held within what an axis can be pushed with.
    precision = np.full(len(columns[0]), case.setting.excitation.torque**-2.0)
    normal = normal_equations(model.residual, columns, [0] * len(columns), precision)
    freedom = sum(block.size for block in model.residual)
    excess = max(1.0, chi2(model.residual) / freedom)
    identity = np.eye(len(precision))
    covariance = excess * solve_weakly_bound(normal.matrix.sum(axis=0), identity, precision)
    half = TWO_SIDED * np.sqrt(np.diag(family.turn @ covariance @ family.turn.T))
    return family.turn @ normal.solution(), half


def _numbers(values: Array) -> tuple[float, ...]:
    return tuple(float(value) for value in values)
