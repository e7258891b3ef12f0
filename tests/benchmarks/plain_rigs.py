"""What a diagnosis says of plain rigs that nothing in gmfbo simulates: motor, counts, slow logger.

    python -m tests.benchmarks.plain_rigs > tests/benchmarks/results/plain_rigs/plain_rigs.txt

A motor with Coulomb friction (and a fan, or an unbalance) is integrated here in steps of 0.1 ms. An
encoder counts, a logger writes rows of 10 or 20 ms. The twin is `motor_bench.fmu`, whose inertia
and viscous friction are off by a few per cent, and which knows nothing of the rest.
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

PLANT = """
[uncertain]
"{m}inertia" = [0.0025, 0.01]
"{m}viscous" = [0.0, 0.08]
[ports]
torque = "{m}tau_load"
command = "{m}current"
[states]
position = "{m}position"
velocity = "{m}velocity"
current = "{m}motor_current"
[roles]
inertia = "{m}inertia"
"""
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
    closed : bool
        Whether a speed loop drives it, which reads that difference.
    counts : int
        A turn.
    """

    friction: float = FRICTION
    extra: Extra = lambda position, velocity: 0.0
    both_ways: bool = False
    rows: float = 0.01
    output: str = "position"
    jitter: float = 0.0
    closed: bool = False
    counts: int = 2000

    def recordings(self, seed: int) -> list[Recording]:
        """Three recordings."""
        rng = np.random.default_rng(seed)
        return [self._recording(rng, f"run{k}.csv") for k in range(3)]

    def _recording(self, rng: np.random.Generator, name: str) -> Recording:
        count = round(8.0 / self.rows)
        late = self.jitter * np.abs(rng.standard_normal(count))
        late += 5.0 * self.jitter * (rng.random(count) < 0.02)
        times = np.cumsum(np.full(count, self.rows) + late) - self.rows
        low, high = (3.0, 15.0) if self.closed else (0.3, 1.0)
        levels = rng.uniform(low, high, 10)
        if self.both_ways:
            levels *= rng.choice([-1.0, 1.0], 10)
        asked = np.where(times < 0.2, 0.0, levels[np.minimum(times // 0.8, 9).astype(int)])
        resolution = 2.0 * np.pi / self.counts
        position, velocity, before, integral = 0.0, 0.0, 0.0, 0.0
        columns: dict[str, list[float]] = {"position": [], "velocity": [], "current": []}
        for k, until in enumerate([*np.diff(times), self.rows]):
            counted = float(np.floor(position / resolution) * resolution)
            speed, before = (counted - before) / self.rows, counted
            current = float(asked[k])
            if self.closed:
                error = current - speed
                wanted = KP * error + integral
                current = float(np.clip(wanted, -LIMIT, LIMIT))
                integral += KI * self.rows * error if current == wanted else 0.0
            for column, value in zip(columns.values(), (counted, speed, current), strict=True):
                column.append(value)
            position, velocity = self._moved(position, velocity, current, round(until / STEP))
        time = np.floor(times * 1e3) * 1e-3 if self.jitter else times
        signals = {"current": columns["current"], self.output: columns[self.output]}
        if self.closed:
            signals["reference"] = asked.tolist()
        arrays = {key: np.array(column) for key, column in signals.items()}
        return Recording(time=time - time[0], signals=arrays, name=name)

    def _moved(
        self, position: float, velocity: float, current: float, steps: int
    ) -> tuple[float, float]:
        """Position and velocity some steps later; friction holds what does not overcome it."""
        for _ in range(steps):
            torque = TORQUE_CONSTANT * current - VISCOUS * velocity
            torque += self.extra(position, velocity)
            if velocity == 0.0 and abs(torque) <= self.friction:
                continue
            way = np.sign(velocity) or np.sign(torque)
            then = velocity + STEP * (torque - self.friction * way) / INERTIA
            if velocity * then < 0.0 and abs(torque) <= self.friction:
                then = 0.0
            position, velocity = position + STEP * then, then
        return position, velocity


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
    "speed loop": Rig(both_ways=True, output="velocity", closed=True),
}


def main() -> int:
    """Print what is told of each rig, and whether the intervals of the twin's parameters hold."""
    with tempfile.TemporaryDirectory() as folder:
        for seed, (name, rig) in enumerate(RIGS.items(), start=1):
            text = (CLOSED if rig.closed else OPEN).replace("{models}", models_folder().as_posix())
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
            truths = {"inertia": INERTIA, "viscous": VISCOUS}
            for key, one in found.parameters.items():
                true = truths[key.rpartition(".")[2]]
                held = "holds" if one.low <= true <= one.high else f"misses {true}"
                print(f"    {key} {one.value:.4g} [{one.low:.4g}, {one.high:.4g}] {held}")
            sys.stdout.flush()
    return 0


if __name__ == "__main__":
    sys.exit(main())
