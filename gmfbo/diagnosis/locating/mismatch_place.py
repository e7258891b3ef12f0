"""Locate the mismatch: part of the loop, state in which it acts, and times."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case, chi2_per_dof
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.diagnosis.locating.latent_state import StateFit, rank_states
from gmfbo.diagnosis.locating.parities import Parities
from gmfbo.diagnosis.locating.parity import FAILS_ABOVE, Parity, block_rows
from gmfbo.diagnosis.locating.times_of_mismatch import (
    MOST_WINDOWS,
    Column,
    Mask,
    Stretch,
    moving_parts,
    smeared,
    strongest,
    time_windows,
)
from gmfbo.diagnosis.result.whereabouts import Location, SignalPath, TimeWindow
from gmfbo.diagnosis.runs.measured_excitation import states_of
from gmfbo.diagnosis.runs.simulated import Simulated
from gmfbo.physics import States, Units
from gmfbo.units import quantity

_ALWAYS = 0.6  # of the rows that move: an effect that acts in more has no special place
_SHOWS_LATE_S = 0.04  # time that the loop takes to show a torque's effect
_ALIKE = 0.8  # of the best score
_STANDS_OUT = 0.25  # of the strongest block
_PARTS: dict[str, tuple[SignalPath, ...]] = {
    "torque": ("plant", "transmission"),
    "command": ("actuator", "controller"),
    "sensor": ("sensor", "controller"),
}
"""Parts of the loop in which what acts at a port may sit, the likeliest first."""


def locate(
    case: Case,
    base: Fitted,
    parities: Parities,
    effects: Sequence[Candidate],
    fitted_with: Fitted | None,
    units: Units,
) -> Location:
    """Say where, in which state and when the twin and its recordings differ.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    base : Fitted
        The twin with its parameters refitted.
    parities : Parities
        Checks of the parts of the loop, about `base`.
    effects : sequence of Candidate
        Effects that were named; may be empty.
    fitted_with : Fitted or None
        The twin with them.
    units : Units
        Of the twin, for words.
    """
    if effects and fitted_with is not None:
        return _of_effects(case, effects, fitted_with, units)
    return _of_parities(case, base, parities, units)


def located_at(location: Location, port: str, against: str) -> Location:
    """Location at a free function's port, where what was read of the signals is no part of it.

    Parameters
    ----------
    location : Location
        As the signals tell it.
    port : str
        Where the function acts.
    against : str
        State on which it depends, or `time`.
    """
    first, *others = _PARTS[port]
    if location.signal_path in (first, *others):
        return location
    return replace(location, signal_path=first, region=f"it depends on the {against}")


def _of_effects(
    case: Case, effects: Sequence[Candidate], fitted_with: Fitted, units: Units
) -> Location:
    """Location by named effects: part and state by their law, times by their change of signals."""
    stretches: list[Stretch] = []
    regions: dict[str, None] = {}
    most = max(1, MOST_WINDOWS // len(effects))
    for candidate in effects:
        own = _where(case, candidate, fitted_with, most)
        stretches += own
        if own:  # friction on a motion one way meets none of the places at which it shows most
            regions[candidate.law.region({**candidate.more, **candidate.values}, units)] = None
    path = effects[0].law.signal_path
    return Location(_path(path), "; ".join(regions), _windows(case, stretches))


def _path(words: str) -> SignalPath:
    found: dict[str, SignalPath] = {
        "controller": "controller",
        "actuator": "actuator",
        "plant": "plant",
        "transmission": "transmission",
        "sensor": "sensor",
    }
    return found[words]


def _where(case: Case, candidate: Candidate, fitted_with: Fitted, most: int) -> list[Stretch]:
    weights = _contribution(case, candidate, fitted_with)
    grids, acts, moves = [], [], []
    for k, (record, run) in enumerate(
        zip(case.simulations.records, fitted_with.simulated, strict=True)
    ):
        states = states_of(run, record)
        scored = _scored(states.time, record.start, record.end)
        if candidate.only is not None and candidate.only != k:
            scored = np.zeros_like(scored)
        grids.append(states.time)
        moves.append((np.abs(states.velocity) > states.rest) & scored)
        acts.append(candidate.law.acts(states, {**candidate.more, **candidate.values}) & scored)
    moving = sum(int(m.sum()) for m in moves)
    both = sum(int((m & a).sum()) for m, a in zip(moves, acts, strict=True))
    if both >= _ALWAYS * moving > 0:
        return moving_parts(grids, moves)[:most]
    return strongest(grids, acts, weights, most)


def _contribution(case: Case, candidate: Candidate, fitted_with: Fitted) -> list[Column]:
    """Squared change of the signals by an effect, in units of noise, on each grid."""
    whole = fitted_with.hypothesis
    others = tuple(c for c in whole.effects if c.effect != candidate.effect)
    without = replace(whole, effects=others)
    point = without.point(without.start(fitted_with.parameters))
    acting, runs = case.simulations.run([whole.point(fitted_with.x), point])
    weights = []
    for k, (after, before) in enumerate(zip(acting, runs, strict=True)):
        grid = case.simulations.records[k].plan.grid
        weights.append(smeared(grid, _squares(case, k, after, before), _SHOWS_LATE_S))
    return weights


def _squares(case: Case, k: int, after: Simulated, before: Simulated) -> Column:
    record = case.simulations.records[k]
    total = np.zeros(record.plan.grid.size)
    for signal, a, b in zip(record.signals, after.signals, before.signals, strict=True):
        noise = case.noise[signal.name].total if signal.name in case.noise else 1.0
        change = np.interp(record.plan.grid, signal.time, np.nan_to_num(a - b))
        total += (change / noise) ** 2
    return total


# ---- without a name ---------------------------------------------------------------------------


def _of_parities(case: Case, base: Fitted, parities: Parities, units: Units) -> Location:
    states = [
        states_of(run, record)
        for run, record in zip(
            parities.held or base.simulated, case.simulations.records, strict=True
        )
    ]
    failing = _failing(parities)
    if failing is None:
        return _of_residuals(case, base, parities)
    part, parity = failing
    ranked = rank_states(parity.columns, states, observed=part == "plant")
    best = _likeliest(ranked)
    path: SignalPath = part
    if part == "plant" and best is not None and best.state == "command":
        path = "actuator"
    at_reversals = best is not None and best.state == "direction"
    return Location(
        path,
        "" if best is None else _region(best, units),
        _windows(case, _outstanding(case, parity, states if at_reversals else None)),
    )


def _likeliest(ranked: Sequence[StateFit]) -> StateFit | None:
    """Best of the states; a command is preferred to the acceleration that it causes.

    Only a wrong inertia truly follows the acceleration, and an uncertain one was refitted.
    """
    if not ranked:
        return None
    best = ranked[0]
    if best.state != "acceleration":
        return best
    close = [f for f in ranked if f.state == "command" and f.score > _ALIKE * best.score]
    return close[0] if close else best


def _failing(parities: Parities) -> tuple[SignalPath, Parity] | None:
    """First failing part; the transmission precedes the plant where its excess is as large."""
    controller, plant, joint = parities.controller, parities.plant, parities.transmission
    if controller is not None and controller.fails:
        return "controller", controller
    if joint is not None and joint.fails and (plant is None or joint.excess >= plant.excess):
        return "transmission", joint
    if plant is not None and plant.fails:
        return "plant", plant
    return ("transmission", joint) if joint is not None and joint.fails else None


def _of_residuals(case: Case, base: Fitted, parities: Parities) -> Location:
    """Location where no part fails: times only, and nothing where a part could be checked."""
    checked = parities.controller, parities.plant
    if any(p is not None for p in checked) or chi2_per_dof(base, case.misfit) < FAILS_ABOVE:
        return Location(None)
    grids, squares, masks = [], [], []
    for k, (record, run) in enumerate(zip(case.simulations.records, base.simulated, strict=True)):
        recorded = Simulated(tuple(s.values for s in record.signals), run.response)
        own = _squares(case, k, recorded, run)
        grids.append(record.plan.grid)
        squares.append(own)
        scored = _scored(record.plan.grid, record.start, record.end)
        masks.append(_heavy(record.plan.grid, own) & scored)
    return Location(None, "", _windows(case, strongest(grids, masks, squares, MOST_WINDOWS)))


def _outstanding(case: Case, parity: Parity, states: Sequence[States] | None) -> list[Stretch]:
    """Stretches with outstanding blocks, near reversals where the signal changes sign there."""
    squares, masks = [], []
    for k, (grid, column) in enumerate(zip(parity.grids, parity.columns, strict=True)):
        own = np.where(np.isfinite(column), column / parity.noise, 0.0) ** 2
        record = case.simulations.records[k]
        mask = _scored(grid, record.start, record.end)
        mask = mask & (_heavy(grid, own) if states is None else states[k].near_reversals())
        squares.append(own)
        masks.append(mask)
    return strongest(parity.grids, masks, squares, MOST_WINDOWS)


def _heavy(grid: Column, square: Column) -> Mask:
    """Rows whose block is a good share of the strongest one."""
    rows = block_rows(grid)
    kernel = np.ones(rows) / rows
    local = np.convolve(square, kernel, mode="same")
    return np.asarray(local > _STANDS_OUT * local.max(), dtype=np.bool_)


def _region(fit: StateFit, units: Units) -> str:
    """Words for the state that a latent signal follows."""
    if fit.state == "direction":
        return "where the velocity changes sign"
    if fit.state == "time":
        return f"in the time around {quantity(fit.at, 's')}"
    if fit.state == "acceleration":
        return "where the acceleration is large"
    named = {
        "velocity": ("velocity", units.velocity),
        "speed": ("velocity", units.velocity),
        "position": ("position", units.position),
        "command": ("command", units.command),
    }
    word, unit = named[fit.state]
    return f"it depends on the {word}, and is largest near {quantity(fit.at, unit)}"


def _scored(grid: NDArray[np.float64], start: float, end: float) -> Mask:
    return np.asarray((grid >= start - 1e-9) & (grid <= end + 1e-9), dtype=np.bool_)


def _windows(case: Case, stretches: Sequence[Stretch]) -> tuple[TimeWindow, ...]:
    return time_windows(stretches, [record.name for record in case.simulations.records])
