"""Time shift, scale and offset of columns against the twin or its controller.

The command is compared with the one that the twin's controller computes from the recorded
measurement. No plant takes part, so missing physics cannot mislead this comparison. It also tells
which column is wrong, since an error of the measurement changes the computed command otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.case.command_signal import command_of
from gmfbo.diagnosis.case.held_out_split import rows_of
from gmfbo.diagnosis.checking.compared_command import ComparedCommand
from gmfbo.diagnosis.checking.result import SeenAlignment
from gmfbo.diagnosis.locating.held_twin import HeldTwin, hold
from gmfbo.diagnosis.locating.parities import Parities
from gmfbo.diagnosis.locating.parity import FAILS_ABOVE
from gmfbo.diagnosis.runs.scored_record import ScoredSignal

Array = NDArray[np.float64]

KINDS = ("shift", "scale", "offset")

LEAST_GAIN = 0.02
"""Share of a gain above which it is told from the stated one."""

UNKNOWN = SeenAlignment("controller", math.nan, math.nan, math.nan, 0.0)
"""Of a column whose expected values are not known."""

LEAST_SHIFT = 2.0
"""Samples to which a shift against the twin is known; one that is less sure is NaN."""

LEAST_SCALE = 0.02
"""Share of a scale from which it is told against the twin; one that is less sure is not known."""

LEAST_OFFSET = 0.01
"""Share of a range from which an offset is told; one that is less sure is not known."""

_ROUND_OFF = 1e-12  # of a column's power: less of its own is none
_LEFT = 0.01  # of a constant's power beside what an integral may hold: less is told as neither
_ROUNDS = 4  # linear steps, enough to find a shift of many samples
_SMALL = 0.01  # change of scale, and of the range, for the controller's derivatives


@dataclass(frozen=True)
class Culprit:
    """One error of a column or of a gain that alone explains the controller's residual.

    Attributes
    ----------
    signal, kind : str
        Column with `shift`, `scale` or `offset`; or gain with `gain`.
    size : float
        Shift [s], share of the values, offset [SI], or share of the gain.
    explained : float
        Share of the squared residual that this error explains.
    """

    signal: str
    kind: str
    size: float
    explained: float


@dataclass(frozen=True, eq=False)
class ControllerView:
    """The controller's residual in one recording, with nothing removed, and its causes.

    Attributes
    ----------
    excess : float
        Mean square of its block means, 1 where the controller is right.
    command, position : SeenAlignment
        Alignment of the command's and of the measurement's column, each as if the other were right.
    culprits : tuple of Culprit
        Single errors of single columns, the one that explains most first; empty, and no alignment
        known, where rows are slower than the controller.
    held : float
        [SI] Constant difference that the controller's integral may have held before the first
        row; 0 where none is seen.
    """

    excess: float
    command: SeenAlignment
    position: SeenAlignment
    culprits: tuple[Culprit, ...]
    held: float = 0.0


def against_twin(case: Case, record: int, place: int) -> SeenAlignment:
    """Align a column with the twin, without changes that the twin's parameters could make.

    NaN stands for what those parameters could as well have made, or what the twin lacks.

    Parameters
    ----------
    case : Case
        At nominal parameters.
    record, place : int
        Indices of the recording and of its signal.
    """
    signal = case.simulations.records[record].signals[place]
    rows = rows_of(case, range(len(case.budget.windows)), record, place)
    free = [column[record][place][rows] for column in case.base.columns]
    simulated = case.base.simulated[record].signals[place]
    return _alignment(signal, simulated, rows, free)


def _alignment(
    signal: ScoredSignal, simulated: Array, rows: NDArray[np.int64], free: Sequence[Array]
) -> SeenAlignment:
    ones = np.ones(rows.size)
    shift, scale, offset = 0.0, 1.0, 0.0
    left = before = _left(signal.values[rows] - simulated[rows], free)
    own: list[Array] = []
    for _ in range(_ROUNDS):
        moved = np.interp(signal.time - shift, signal.time, simulated)
        rate = np.gradient(moved, signal.spacing)[rows]
        own = [moved[rows], ones, -rate]
        target = signal.values[rows] - moved[rows]
        together = np.column_stack([*own, *free])
        size = np.sqrt(np.mean(together**2, axis=0))
        size = np.where(size > 0.0, size, 1.0)
        found = np.linalg.lstsq(together / size, target, rcond=1e-9)[0] / size
        left = float(np.mean((target - together @ found) ** 2))
        scale, offset = 1.0 + float(found[0]), float(found[1])
        shift += float(found[2]) / (scale or 1.0)
    told = {
        kind: size if _error(place, own, free, left) <= least else math.nan
        for place, (kind, size, least) in enumerate(
            (
                ("scale", scale, LEAST_SCALE),
                ("offset", offset, LEAST_OFFSET * float(np.ptp(signal.values))),
                ("shift", shift, LEAST_SHIFT * signal.spacing),
            )
        )
    }
    return SeenAlignment("twin", **told, explained=1.0 - left / before if before else 0.0)


def _error(place: int, own: Sequence[Array], free: Sequence[Array], left: float) -> float:
    """Size of an error that missing physics as large as what is left can make, at most.

    What is left is no white noise: it may run along a column as well as beside it. Only the part
    of the column counts that no other one, such as a change of the twin's parameters, makes.
    """
    others = [*own[:place], *own[place + 1 :], *free]
    alone = _left(own[place], others)
    usual = float(np.mean(own[place] ** 2))
    return math.sqrt(left / alone) if alone > _ROUND_OFF * usual else math.inf


def _left(target: Array, free: Sequence[Array]) -> float:
    if not free:
        return float(np.mean(target**2))
    columns = np.column_stack(free)
    size = np.sqrt(np.mean(columns**2, axis=0))
    size = np.where(size > 0.0, size, 1.0)
    found = np.linalg.lstsq(columns / size, target, rcond=1e-9)[0] / size
    return float(np.mean((target - columns @ found) ** 2))


def against_controller(case: Case, checked: Parities, rows: Sequence[str]) -> list[ControllerView]:
    """Align the commands at nominal parameters; empty where the controller was not checked.

    Parameters
    ----------
    case : Case
        At nominal parameters.
    checked : Parities
        Runs of the twin that was held on its recordings.
    rows : sequence of str
        Whether the rows of each recording store the `held` or the `new` command.
    """
    command = command_of(case)
    if checked.controller is None or command is None or case.rig.position is None:
        return []
    twin = hold(case, case.base, case.rig.position)
    noise = checked.controller.noise
    views = []
    for k, run in enumerate(checked.held):
        compared = ComparedCommand(case, k, command, rows[k], checked.memories[k])
        if checked.slower_rows:
            # What it read between two rows is unknown, and with it what a column should be.
            residual = compared.residual(run.response.held[command])
            excess = float(np.mean(residual**2)) / noise**2
            views.append(ControllerView(excess, UNKNOWN, UNKNOWN, ()))
            continue
        computed = compared.computed(run.response)
        view = _view(compared, twin, computed, noise)
        if view.excess > FAILS_ABOVE:
            view = _with_gains(compared, twin, computed, view)
        views.append(view)
    return views


def _with_gains(
    compared: ComparedCommand, twin: HeldTwin, expected: Array, view: ControllerView
) -> ControllerView:
    """Add each controller gain as a possible cause: the drive may have had another value."""
    case, k = compared.case, compared.record
    residual = compared.residual(expected)
    before = float(np.mean(residual**2))
    point = case.base.hypothesis.point(case.base.x)
    in_force = case.simulations.records[k].plan.experiment.parameters.in_force
    measured = twin.recorded(k)
    culprits = list(view.culprits)
    for name in case.twin.file.gains:
        value = float(in_force.get(name, case.twin.nominal(name)))
        if not value:
            continue
        changed = replace(point, parameters={**point.parameters, name: (1.0 + _SMALL) * value})
        run = case.simulations.run_parity(changed, k, twin.settings, measured)
        if run.outcome.status != "ok":
            continue
        answer = compared.means(compared.computed(run) - expected)
        size, left = _alone(residual, answer)
        culprits.append(Culprit(name, "gain", _SMALL * size, _explained(before, left)))
    return replace(view, culprits=_ordered(culprits))


def _ordered(culprits: Sequence[Culprit]) -> tuple[Culprit, ...]:
    return tuple(sorted(culprits, key=lambda culprit: -culprit.explained))


def _answers(
    compared: ComparedCommand, twin: HeldTwin, expected: Array
) -> dict[str, tuple[float, Array]]:
    """Changes of the computed command by small errors of the measurement, and their sizes."""
    case, k = compared.case, compared.record
    measured = twin.recorded(k)
    step = case.twin.step
    size = _SMALL * float(np.ptp(measured))
    earlier = np.concatenate([measured[1:], measured[-1:]])
    changed = {
        # A column that is late by a step has to be read a step ahead.
        "shift": (step, earlier),
        "scale": (_SMALL, measured / (1.0 + _SMALL)),
        "offset": (size * case.rig.position_to_si, measured - size),
    }
    answers = {}
    for kind, (amount, column) in changed.items():
        runs = twin.run({k: column})
        if runs is not None:
            answers[kind] = (amount, expected - compared.computed(runs[0]))
    return answers


def _view(
    compared: ComparedCommand, twin: HeldTwin, expected: Array, noise: float
) -> ControllerView:
    answers = _answers(compared, twin, expected)
    residual = compared.residual(expected)
    own = _aligned(compared.grid, compared.recorded(), expected, compared.means)
    before = float(np.mean(residual**2))
    culprits = [
        Culprit(compared.command, kind, size, _explained(before, left))
        for kind, (size, left) in own.single.items()
    ]
    for kind, (amount, answer) in answers.items():
        # A reading that is too large made the controller compute `answer` too much.
        size, left = _alone(residual, -compared.means(answer))
        position = compared.case.rig.position or ""
        culprits.append(Culprit(position, kind, amount * size, _explained(before, left)))
    seen = SeenAlignment(
        "controller", own.shift, own.scale, own.offset, _explained(before, own.left)
    )
    measured = _measured(residual, answers, compared.means)
    held = 0.0
    if before / noise**2 <= FAILS_ABOVE:
        held = compared.held_throughout(expected, math.sqrt(FAILS_ABOVE) * noise)
    return ControllerView(before / noise**2, seen, measured, _ordered(culprits), held)


def _measured(
    residual: Array,
    answers: dict[str, tuple[float, Array]],
    means: Callable[[Array], Array],
) -> SeenAlignment:
    """Least-squares shift, scale and offset of the measurement for the controller's residual."""
    if len(answers) < len(KINDS):
        return UNKNOWN
    columns = np.column_stack([-means(answers[kind][1]) for kind in KINDS])
    size = np.sqrt(np.mean(columns**2, axis=0))
    size = np.where(size > 0.0, size, 1.0)
    found = np.linalg.lstsq(columns / size, residual, rcond=1e-9)[0] / size
    shift, scale, offset = (
        answers[kind][0] * float(share) for kind, share in zip(KINDS, found, strict=True)
    )
    before, left = np.mean(residual**2), np.mean((residual - columns @ found) ** 2)
    return SeenAlignment(
        "controller", shift, 1.0 + scale, offset, _explained(float(before), float(left))
    )


@dataclass(frozen=True)
class _Aligned:
    """Errors of the command column, fitted together and alone as (size, mean square left)."""

    shift: float
    scale: float
    offset: float
    left: float
    single: dict[str, tuple[float, float]]


def _aligned(
    grid: Array, recorded: Array, expected: Array, means: Callable[[Array], Array]
) -> _Aligned:
    shift = 0.0
    scale, offset, left = 1.0, 0.0, 0.0
    alone = 0.0
    constant = means(np.ones(grid.size))
    is_told = float(np.mean(constant**2)) > _LEFT
    target = means(recorded - expected)
    single: dict[str, tuple[float, float]] = {}
    for _ in range(_ROUNDS):
        moved = np.interp(grid - shift, grid, expected)
        columns = np.column_stack(
            [
                means(moved),
                constant if is_told else 0.0 * constant,
                -means(np.gradient(moved, grid)),
            ]
        )
        target = means(recorded - moved)
        found = np.linalg.lstsq(columns, target, rcond=1e-9)[0]
        left = float(np.mean((target - columns @ found) ** 2))
        scale, offset = 1.0 + float(found[0]), float(found[1])
        shift += float(found[2]) / (scale or 1.0)
    for _ in range(_ROUNDS):
        moved = np.interp(grid - alone, grid, expected)
        target = means(recorded - moved)
        more, remains = _alone(target, -means(np.gradient(moved, grid)))
        alone += more
        single["shift"] = (alone, remains)
    target = means(recorded - expected)
    single["scale"] = _alone(target, means(expected))
    if is_told:
        single["offset"] = _alone(target, constant)
    return _Aligned(shift, scale, offset if is_told else math.nan, left, single)


def _alone(target: Array, column: Array) -> tuple[float, float]:
    """Least-squares factor of one column, and the mean square left."""
    square = float(column @ column)
    size = float(column @ target) / square if square else 0.0
    return size, float(np.mean((target - size * column) ** 2))


def _explained(before: float, left: float) -> float:
    return 1.0 - left / before if before else 0.0
