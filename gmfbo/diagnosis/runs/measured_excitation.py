"""Measured excitation: ranges of the recorded motion, by which effects are bounded and scaled."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid
from scipy.spatial import ConvexHull

from gmfbo.diagnosis.runs.scored_record import Record
from gmfbo.diagnosis.runs.simulated import Point, Simulated
from gmfbo.diagnosis.runs.simulations import Simulations
from gmfbo.physics import Excitation, States
from gmfbo.physics.excitation import NOTHING

_UNSEEN_STEP = 1e-3  # of the stroke: largest resolution assumed where none was recorded
_REST_SHARE = 0.01  # of the fastest motion: slower is standstill
_AT_REST = 0.02  # of the motion caused by a push: a smaller distance counts as rest
_CLEAR = 20.0  # times its noise: a motion whose speed is known
_PROBE_SHARES = (0.02, 0.3)  # of the command's range: wanted answer to a probing torque


def states_of(simulated: Simulated, record: Record) -> States:
    """States on which effects depend, of one simulated recording on the communication grid."""
    states, grid = simulated.response.states, record.plan.grid
    position = states.get("position", np.zeros(grid.size))
    velocity = states.get("velocity")
    if velocity is None:
        velocity = np.gradient(position, grid)
    command = states.get("command", states.get("current", np.zeros(grid.size)))
    speed = float(np.quantile(np.abs(velocity), 0.995))
    return States(
        time=grid,
        position=position,
        velocity=velocity,
        command=command,
        current=states.get("current", command),
        rest=_REST_SHARE * speed,
        load_torque=states.get("load_torque"),
    )


def reversals(*states: States) -> int:
    """Changes of direction after which an axis travels on, also from one recording to the next.

    An axis that follows encoder counts, or noise, changes the sign of its velocity many times while
    it moves one way: a change counts where it then goes back by more than a resolution.
    """
    travels = [cumulative_trapezoid(s.velocity, s.time, initial=0) for s in states]
    least = _UNSEEN_STEP * max(float(np.ptp(travel)) for travel in travels)
    ways = [way for travel in travels for way in _ways(travel, least)]
    return int(np.count_nonzero(np.diff(ways)))


def _ways(travel: NDArray[np.float64], least: float) -> list[int]:
    """Directions in which an axis goes on for longer than this, one after the other."""
    steps = np.diff(travel)
    turning = np.flatnonzero(np.diff(np.sign(steps[steps != 0.0])))
    ends = travel[np.flatnonzero(steps)[turning] + 1]
    ways, low, high = list[int](), float(travel[0]), float(travel[0])
    for end in map(float, (*ends, travel[-1])):
        way = ways[-1] if ways else 0
        low, high = min(low, end), max(high, end)
        if way <= 0 and end > low + least:
            ways.append(1)
            high = end
        elif way >= 0 and end < high - least:
            ways.append(-1)
            low = end
    return ways


def demands(*states: States) -> tuple[tuple[float, float], ...]:
    """Corners (velocity along the command, |command|) of the motion, where falling limits are met.

    What brakes has a velocity below zero there.
    """
    given = np.concatenate([s.command for s in states])
    velocity = np.concatenate([s.velocity for s in states])
    speed, command = np.where(given < 0.0, -velocity, velocity), np.abs(given)
    fastest, largest = float(np.abs(speed).max()), float(command.max())
    if fastest <= 0.0 or largest <= 0.0:
        return ()
    # Between the axes and the points on them the hull has an area, and corners that count.
    points = np.stack(
        [np.append(speed, [0.0, fastest, 0.0]), np.append(command, [0.0, 0.0, largest])]
    )
    corners = ConvexHull((points / [[fastest], [largest]]).T).vertices
    return tuple((float(points[0, k]), float(points[1, k])) for k in sorted(corners))


@dataclass(frozen=True)
class Stiffness:
    """Response of the twin to a torque at its port.

    Attributes
    ----------
    per_command : float
        Torque that one unit of command balances.
    loop_time : float
        [s] Time constant of the command's answer.
    rest_time : float
        [s] Time until position and command stay within 2 % of their final values after a push.
    is_open : bool
        Whether a pushed shaft does not come back.
    inertia : float or None
        Torque per acceleration, measured by a short push.
    """

    per_command: float
    loop_time: float
    rest_time: float
    is_open: bool
    inertia: float | None


def probe_torque(
    simulations: Simulations, point: Point, base: Sequence[Simulated], guess: float
) -> Stiffness:
    """Push the shaft by a torque that lasts for half of a recording.

    Parameters
    ----------
    simulations : Simulations
        Simulators of the twin, without tracking.
    point : Point
        Values at which the twin runs.
    base : sequence of Simulated
        The recordings simulated without a push.
    guess : float
        Torque to begin with; it is scaled until the command answers well within its range.
    """
    sizes = [record.plan.grid.size for record in simulations.records]
    longest_first = np.argsort([-size for size in sizes], kind="stable")
    found = []
    for k in longest_first:
        found.append(_probe_torque_along(simulations, point, base, guess, int(k)))
        # A saturated loop does not answer a push: the twin is open only if no recording answers.
        if not found[-1].is_open:
            return found[-1]
    return found[0]


def _probe_torque_along(
    simulations: Simulations, point: Point, base: Sequence[Simulated], guess: float, k: int
) -> Stiffness:
    grid = simulations.records[k].plan.grid
    states = base[k].response.states
    half = grid.size // 2
    push = guess
    for _ in range(6):
        column = np.where(np.arange(grid.size) < half, push, 0.0)
        if simulations.records[k].plan.lead:
            column[0] = 0.0  # the first row is held before the recording begins
        run = simulations.run_one(point, k, excitation={"torque": column})
        if not run.finite:
            push *= 0.01
            continue
        moved = run.response.states.get("position", np.zeros(grid.size)) - states.get(
            "position", np.zeros(grid.size)
        )
        answer = _answer(run, base[k], half)
        command, extent = answer or (np.zeros(grid.size), 1.0)
        share = float(np.abs(np.median(command[half // 2 : half]))) / extent
        # A loop at its limit lets the shaft go too: only one that has not come near is none.
        if share < _PROBE_SHARES[1] and _leaves(moved, half):
            return Stiffness(np.nan, np.nan, np.nan, True, _inertia(moved, grid, push, half))
        if answer is None:
            times = _time_constant(moved, grid, half), _rest_time([moved], grid, half)
            return Stiffness(np.nan, *times, False, None)
        if _PROBE_SHARES[0] < share < _PROBE_SHARES[1]:
            ratio = push / float(np.abs(np.median(command[half // 2 : half])))
            times = _time_constant(command, grid, half), _rest_time([moved, command], grid, half)
            return Stiffness(ratio, *times, False, None)
        push *= float(np.clip(0.1 / max(share, 1e-6), 1e-4, 1e4))
    return Stiffness(np.nan, np.nan, np.nan, False, None)


def _leaves(moved: NDArray[np.float64], half: int) -> bool:
    """Whether the shaft never returns after a push: no nearer at the end than at half time."""
    end, most = float(np.abs(moved[-1])), float(np.abs(moved).max())
    return most > 0.0 and end > 0.5 * most and end >= 0.9 * float(np.abs(moved[half - 1]))


def _inertia(
    moved: NDArray[np.float64], grid: NDArray[np.float64], push: float, half: int
) -> float | None:
    rows = slice(0, max(10, half // 8))
    time = grid[rows] - grid[0]
    curve = np.polyfit(time, moved[rows], 2)
    return float(abs(push / (2.0 * curve[0]))) if curve[0] else None


def _answer(run: Simulated, base: Simulated, half: int) -> tuple[NDArray[np.float64], float] | None:
    if "command" not in base.response.states:
        return None
    before = base.response.states["command"]
    extent = float(np.abs(before).max())
    return run.response.states["command"] - before, extent or 1.0


def _time_constant(answer: NDArray[np.float64], grid: NDArray[np.float64], half: int) -> float:
    """[s] Time until a step's answer stays within 37 % of its final value."""
    final = float(np.median(answer[half // 2 : half]))
    return _settled(np.abs(answer[:half] - final) > 0.37 * abs(final), grid)


def _rest_time(
    answers: Sequence[NDArray[np.float64]], grid: NDArray[np.float64], half: int
) -> float:
    """[s] Time until all answers to a step stay near their final values; else the whole step."""
    far = np.zeros(half, dtype=bool)
    for answer in answers:
        pushed = answer[:half]
        end = float(np.mean(pushed[-max(1, half // 20) :]))
        far |= np.abs(pushed - end) > _AT_REST * np.abs(pushed).max()
    return _settled(far, grid)


def _settled(far: NDArray[np.bool_], grid: NDArray[np.float64]) -> float:
    """[s] Until an answer has been near its end for as long as it took to get there.

    Where the axis meets a limit or turns later on, the answer leaves its end for a moment: that
    says nothing of the loop.
    """
    rows = np.flatnonzero(far)
    if not rows.size:
        return float(grid[1] - grid[0])
    # An answer that swings passes its end, which is no stay.
    stays = np.flatnonzero(np.diff(rows) > np.maximum(rows[:-1] + 1, far.size // 100))
    last = rows[stays[0]] if stays.size else rows[-1]
    return float(grid[int(last) + 1] - grid[0])


def measure_ranges(
    records: Sequence[Record],
    base: Sequence[Simulated],
    *,
    torque: float,
    command: float,
    speed: float | None,
    step: float,
    loop_time: float,
    resolution: float,
    inertia: float | None,
    angular: bool,
) -> Excitation:
    """Measure the excitation by the recordings.

    Parameters
    ----------
    records : sequence of Record
        Recordings that are scored.
    base : sequence of Simulated
        The recordings simulated.
    torque, command, speed : float
        [FMU's unit] Range of the command (`probing_torque.command_range`), torque for it, and
        fastest recorded motion (`recorded_speed`); None stands for that of the twin.
    step, loop_time : float
        [s] At which effects are stepped; of the closed loop.
    resolution : float
        [FMU's unit] Of the position; 0 where it is not among the outputs.
    inertia : float or None
        Torque per acceleration of the shaft.
    angular : bool
        The position is an angle.
    """
    states = [states_of(run, record) for run, record in zip(base, records, strict=True)]
    durations = [float(np.ptp(record.plan.grid)) for record in records]
    simulated = _positive(np.abs(np.concatenate([s.command for s in states])).max())
    command = max(simulated, command)  # currents go with it
    current = command / simulated * np.concatenate([s.current for s in states])
    sample = float(np.median([s.spacing for r in records for s in r.signals]))
    speed = _positive(_fastest([s.velocity for s in states]) if speed is None else speed)
    stroke = _positive(np.ptp(np.concatenate([s.position for s in states])))
    return Excitation(
        torque=_positive(torque),
        command=command,
        command_rate=_positive(max(np.abs(np.diff(s.command)).max() / s.step for s in states)),
        current=_positive(np.abs(current).max()),
        speed=speed,
        stroke=stroke,
        resolution=_positive(resolution, min(speed * sample, _UNSEEN_STEP * stroke)),
        duration=max(durations),
        total=sum(durations),
        sample=sample,
        step=step,
        loop_time=_positive(loop_time, 0.05),
        inertia=inertia,
        angular=angular,
        reversals=reversals(*states),
        load=_largest_load(states),
        effective_current=_positive(np.sqrt(np.mean(current**2))),
    )


def recorded_speed(
    records: Sequence[Record], scales: Mapping[str, float], position: str | None
) -> float | None:
    """Fastest motion that was recorded [FMU's unit]; None where noise or counts hide it.

    A twin that lacks a limit or friction may move several times as fast, and a law acts at the
    speeds of the axis.

    Parameters
    ----------
    records : sequence of Record
        Recordings that are scored.
    scales : mapping of str to float
        [SI unit / FMU's unit] Of the signals that are the position, or else the velocity.
    position : str or None
        Which of them is the position.
    """
    found = []
    for record in records:
        for signal in record.signals:
            if signal.name in scales:
                values, spacing = signal.values / scales[signal.name], signal.spacing
                counts = signal.resolution / abs(scales[signal.name])
                is_position = signal.name == position
                found.append(_slopes(values, spacing, counts) if is_position else values)
    known = [velocity for velocity in found if velocity.size]
    return _fastest(known) if known else None


def _slopes(position: NDArray[np.float64], spacing: float, counts: float) -> NDArray[np.float64]:
    """Velocity over the shortest time that noise and counts do not drown; empty without one."""
    unsure, rows = max(float(np.median(np.abs(np.diff(position, 2)))), counts), 1
    while rows < position.size // 4:
        moved = position[rows:] - position[:-rows]
        if _fastest([moved]) > _CLEAR * unsure:
            return moved / (rows * spacing)
        rows *= 2
    return np.zeros(0)


def _fastest(velocities: Sequence[NDArray[np.float64]]) -> float:
    return float(np.quantile(np.abs(np.concatenate(velocities)), 0.995))


def _largest_load(states: Sequence[States]) -> float | None:
    loads = [np.abs(s.load_torque).max() for s in states if s.load_torque is not None]
    return _positive(max(loads)) if loads else None


def _positive(value: float | np.floating, otherwise: float = NOTHING) -> float:
    number = float(value)
    return number if np.isfinite(number) and number > 0.0 else otherwise
