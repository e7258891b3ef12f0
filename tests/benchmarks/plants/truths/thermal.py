"""A heated body with a slow sensor and radiation."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping

import numpy as np

from gmfbo.recordings.recording import Recording
from tests.benchmarks.plants.truths.conditions import Conditions, Vector
from tests.benchmarks.plants.truths.laws import Pid

SAMPLE, SUBSTEPS = 0.5, 5
CAPACITY, LOSS, RADIATION = 520.0, 4.2, 1.2e-8
"""[J/K], [W/K], [W/K4]"""
DEAD_TIME, SENSOR_TIME, COUNT = 12.0, 5.0, 0.02
"""[s], [s], [K]"""
AMBIENT, MOST_POWER = 293.15, 1500.0
"""[K], [W]"""


def temperature(
    gains: Mapping[str, float], reference: Recording, conditions: Conditions
) -> dict[str, Vector]:
    """The loss to the surroundings differs from run to run as friction does elsewhere."""
    wanted = reference.signal("reference")
    noise = conditions.noise(0.03, len(wanted))
    law = Pid(
        {name.rpartition(".")[2]: value for name, value in gains.items()},
        sample=SAMPLE,
        limits=(0.0, MOST_POWER),
        anti_windup=0.05,
    )
    body = seen = AMBIENT
    power, waiting = 0.0, deque([0.0] * round(DEAD_TIME / SAMPLE))
    capacity = conditions.inertia * CAPACITY
    share, h = -math.expm1(-SAMPLE / SUBSTEPS / SENSOR_TIME), SAMPLE / SUBSTEPS
    out = np.empty((2, len(wanted)))
    for k, target in enumerate(wanted.tolist()):
        reading = COUNT * math.floor((seen + noise[k]) / COUNT + 0.5)
        out[:, k] = reading, power
        power = law.next(target, reading)
        waiting.append(power)
        arrived = waiting.popleft()
        for _ in range(SUBSTEPS):
            lost = conditions.friction * LOSS * (body - AMBIENT)
            lost += RADIATION * (body**4 - AMBIENT**4)
            body += h / capacity * (arrived - lost)
            seen += share * (body - seen)
    return {"time": reference.time, "reference": wanted, "temperature": out[0], "power": out[1]}
