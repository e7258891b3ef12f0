"""What a diagnosis says of plain rigs that nothing in gmfbo simulates: motor, counts, slow logger.

    python -m tests.benchmarks.plain_rigs > tests/benchmarks/results/plain_rigs/plain_rigs.txt

A motor with Coulomb friction (or a fan, an unbalance, a gap in its gear, a late or dead drive) is
integrated here in steps of 0.1 ms. An encoder counts, a logger writes rows of 10 or 20 ms. The twin
is `motor_bench.fmu`, alone or under a controller, whose inertia and viscous friction are off by a
few per cent, and which knows nothing of the rest.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gmfbo import FmuTwin, Recording, diagnose, models_folder

Array = NDArray[np.float64]
Extra = Callable[[float, float], float]

STEP = 1e-4  # [s]
INERTIA, TORQUE_CONSTANT, VISCOUS, FRICTION = 0.0052, 0.5, 0.021, 0.04
KP, KI, LIMIT = 0.05, 0.4, 1.0  # of the speed loop [A s/rad], [A/rad], [A]
KP_POSITION, KD, PERIOD, MOST = 1.2, 0.08, 5e-3, 1.5  # of the other [A/rad], [A s/rad], [s], [A]
LOAD, CONTACT, CONTACT_DAMPING = 0.004, 400.0, 0.02  # behind a gap [kg m2], [N m/rad], [N m s/rad]

RANGES = """
[uncertain]
"{m}inertia" = [0.0025, 0.01]
"{m}viscous" = [0.0, 0.08]
"""
WHERE = """[ports]
torque = "{m}tau_load"
command = "{m}current"
[states]
position = "{m}position"
velocity = "{m}velocity"
current = "{m}motor_current"
[roles]
inertia = "{m}inertia"
"""
"""Ports, states and roles of `motor_bench.fmu`, whose names begin with m."""
PLANT = RANGES + WHERE
OPEN = """name = "motor"
fmu = "{models}/motor_bench.fmu"
step = 1e-3
[inputs]
current = "current"
[outputs]
{output} = "{output}"
""" + PLANT.format(m="")
CLOSED = """name = "speed loop"
step = 1e-2
[fmus]
controller = "{models}/pid.fmu"
motor = "{models}/motor_bench.fmu"
[wires]
"controller.measured" = "motor.velocity"
"motor.current" = "controller.u"
[inputs]
reference = "controller.reference"
[outputs]
velocity = "motor.velocity"
current = "controller.u"
[parameters]
"controller.kp" = 0.05
"controller.ki" = 0.4
"controller.sample_time" = 0.01
"controller.u_min" = -1.0
"controller.u_max" = 1.0
""" + PLANT.format(m="motor.")
POSITION = """name = "position loop"
step = 5e-3
[fmus]
controller = "{models}/pid.fmu"
motor = "{models}/motor_bench.fmu"
[wires]
"controller.measured" = "motor.position"
"motor.current" = "controller.u"
[inputs]
reference = "controller.reference"
[outputs]
position = "motor.position"
current = "controller.u"
[parameters]
"controller.kp" = 1.2
"controller.kd" = 0.08
"controller.ki" = 0.0
"controller.filter_time" = 0.005
"controller.sample_time" = 0.005
"controller.derivative_weight" = 0.0
"controller.u_min" = -1.5
"controller.u_max" = 1.5
""" + PLANT.format(m="motor.").replace("[states]", 'sensor = "controller.measured"\n[states]')
TWINS = {"": OPEN, "speed": CLOSED, "position": POSITION}


@dataclass(frozen=True)
class Rig:
    """One rig: what it hides, how it is driven, what its logger writes.

    Attributes
    ----------
    friction : float
        [N m] Coulomb friction.
    extra : callable (position [rad], velocity [rad/s]) -> float
        [N m] Any other torque.
    both_ways : bool
        Whether it is driven to and fro.
    rows : float
        [s] From row to row.
    output : str
        `position`, or `velocity` as the difference of two rows of counts.
    jitter : float
        [s] By which rows are late, about; their times are whole milliseconds then.
    closed : str
        Whether a loop drives it: one of the `speed`, which reads that difference, or one of the
        `position`, which reads the counts.
    counts : int
        A turn.
    delay : float
        [s] Of the drive.
    dead_zone : float
        [A] Of the drive, to either side.
    gap : float
        [rad] In front of a load.
    """

    friction: float = FRICTION
    extra: Extra = lambda position, velocity: 0.0
    both_ways: bool = False
    rows: float = 0.01
    output: str = "position"
    jitter: float = 0.0
    closed: str = ""
    counts: int = 2000
    delay: float = 0.0
    dead_zone: float = 0.0
    gap: float = 0.0

    def recordings(self, seed: int) -> list[Recording]:
        """Three recordings."""
        rng = np.random.default_rng(seed)
        return [self._recording(rng, f"run{k}.csv") for k in range(3)]

    def _recording(self, rng: np.random.Generator, name: str) -> Recording:
        count = round(8.0 / self.rows)
        late = self.jitter * np.abs(rng.standard_normal(count))
        late += 5.0 * self.jitter * (rng.random(count) < 0.02)
        times = np.cumsum(np.full(count, self.rows) + late) - self.rows
        low, high = {"": (0.3, 1.0), "speed": (3.0, 15.0), "position": (0.3, 1.5)}[self.closed]
        levels = rng.uniform(low, high, 10)
        if self.both_ways:
            levels *= rng.choice([-1.0, 1.0], 10)
        asked = np.where(times < 0.2, 0.0, levels[np.minimum(times // 0.8, 9).astype(int)])
        axis, before = Axis(self), 0.0
        columns: dict[str, list[float]] = {"position": [], "velocity": [], "current": []}
        for k, until in enumerate([*np.diff(times), self.rows]):
            counted = axis.counted
            speed, before = (counted - before) / self.rows, counted
            current = axis.moved(float(asked[k]), speed, round(until / STEP))
            for column, value in zip(columns.values(), (counted, speed, current), strict=True):
                column.append(value)
        time = np.floor(times * 1e3) * 1e-3 if self.jitter else times
        signals = {"current": columns["current"], self.output: columns[self.output]}
        if self.closed:
            signals["reference"] = asked.tolist()
        arrays = {key: np.array(column) for key, column in signals.items()}
        return Recording(time=time - time[0], signals=arrays, name=name)


class Axis:
    """A rig at work, from rest.

    Parameters
    ----------
    rig : Rig
        What it is.
    """

    def __init__(self, rig: Rig) -> None:
        self.rig = rig
        self.position, self.velocity = 0.0, 0.0
        self.load_position, self.load_velocity = 0.0, 0.0
        self.integral, self.read, self.rate = 0.0, 0.0, 0.0
        self.sent = [0.0] * round(rig.delay / STEP)

    @property
    def counted(self) -> float:
        """[rad] Position by the encoder."""
        resolution = 2.0 * np.pi / self.rig.counts
        return float(np.floor(self.position / resolution) * resolution)

    def moved(self, asked: float, speed: float, steps: int) -> float:
        """Move some steps on, and return the current [A] that was asked of the drive at first."""
        current = first = asked
        if self.rig.closed == "speed":
            current = first = self._speed_control(asked, speed)
        for i in range(steps):
            if self.rig.closed == "position" and i % round(PERIOD / STEP) == 0:
                current = self._position_control(asked)
                first = current if i == 0 else first
            self.sent.append(current)
            self._step(self.sent.pop(0))
        return first

    def _speed_control(self, asked: float, speed: float) -> float:
        wanted = KP * (asked - speed) + self.integral
        current = float(np.clip(wanted, -LIMIT, LIMIT))
        self.integral += KI * self.rig.rows * (asked - speed) if current == wanted else 0.0
        return current

    def _position_control(self, asked: float) -> float:
        counted = self.counted
        self.rate += 0.5 * ((counted - self.read) / PERIOD - self.rate)  # a filter of 5 ms
        self.read = counted
        wanted = KP_POSITION * (asked - counted) - KD * self.rate
        return float(np.clip(wanted, -MOST, MOST))

    def _step(self, current: float) -> None:
        """One step of the motor; friction holds what does not overcome it."""
        rig, velocity = self.rig, self.velocity
        acting = float(np.sign(current)) * max(0.0, abs(current) - rig.dead_zone)
        torque = TORQUE_CONSTANT * acting - VISCOUS * velocity
        torque += rig.extra(self.position, velocity) - self._load_torque()
        if velocity == 0.0 and abs(torque) <= rig.friction:
            return
        way = np.sign(velocity) or np.sign(torque)
        then = velocity + STEP * (torque - rig.friction * way) / INERTIA
        if velocity * then < 0.0 and abs(torque) <= rig.friction:
            then = 0.0
        self.position, self.velocity = self.position + STEP * then, then

    def _load_torque(self) -> float:
        """[N m] Of the load on the motor, which moves on."""
        if not self.rig.gap:
            return 0.0
        twist, half = self.position - self.load_position, 0.5 * self.rig.gap
        torque = CONTACT * (twist - float(np.clip(twist, -half, half)))
        if torque:
            torque += CONTACT_DAMPING * (self.velocity - self.load_velocity)
        self.load_velocity += STEP * torque / LOAD
        self.load_position += STEP * self.load_velocity
        return torque


RIGS = {
    "one way": Rig(),
    "one way, nothing hidden": Rig(friction=0.0),
    "one way, a fan": Rig(extra=lambda position, velocity: -4e-4 * velocity * abs(velocity)),
    "one way, unbalanced": Rig(extra=lambda position, velocity: 0.05 * float(np.sin(position))),
    "to and fro": Rig(both_ways=True),
    "to and fro, rows that jitter": Rig(both_ways=True, jitter=8e-4, counts=600),
    "the same, nothing hidden": Rig(friction=0.0, both_ways=True, jitter=8e-4, counts=600),
    "speed of 20 ms rows": Rig(both_ways=True, rows=0.02, output="velocity"),
    "the same, nothing hidden either": Rig(0.0, both_ways=True, rows=0.02, output="velocity"),
    "speed loop": Rig(both_ways=True, output="velocity", closed="speed"),
    "dead zone": Rig(0.0, both_ways=True, output="velocity", dead_zone=0.1),
    "gap": Rig(0.0, both_ways=True, counts=4000, gap=0.2),
    "position loop": Rig(both_ways=True, closed="position", counts=4000),
    "position loop, nothing hidden": Rig(0.0, both_ways=True, closed="position", counts=4000),
    "position loop, delay": Rig(0.0, both_ways=True, closed="position", counts=4000, delay=0.01),
}


def main() -> int:
    """Print what is told of each rig, and whether the intervals of the twin's parameters hold."""
    with tempfile.TemporaryDirectory() as folder:
        for seed, (name, rig) in enumerate(RIGS.items(), start=1):
            text = TWINS[rig.closed].replace("{models}", models_folder().as_posix())
            path = Path(folder) / "twin.toml"
            path.write_text(text.replace("{output}", rig.output), encoding="utf-8")
            first, second, unseen = rig.recordings(seed)
            found = diagnose(FmuTwin(path), [first, second], [unseen], seed=0, jobs=2)
            cost = f"{found.cost.simulations} simulations, {found.cost.seconds:.0f} s"
            print(f"{name}: {found.verdict} ({cost})")
            for effect in found.effects:
                size, value = next(iter(effect.parameters.items()))
                told = f"{value.value:.4g} [{value.low:.4g}, {value.high:.4g}] {value.unit}"
                print(f"    {' or '.join(effect.set)}, {effect.probability:.2f}: {size} {told}")
            truths = {"inertia": INERTIA + (LOAD if rig.gap else 0.0), "viscous": VISCOUS}
            for key, one in found.parameters.items():
                true = truths[key.rpartition(".")[2]]
                held = "holds" if one.low <= true <= one.high else f"misses {true}"
                print(f"    {key} {one.value:.4g} [{one.low:.4g}, {one.high:.4g}] {held}")
            sys.stdout.flush()
    return 0


if __name__ == "__main__":
    sys.exit(main())
