"""An inverted pendulum on a cart with dry friction, behind an amplifier with a lag."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from gmfbo.recordings.recording import Recording
from tests.benchmarks.plants.truths.conditions import Conditions, Fallen, Vector
from tests.benchmarks.plants.truths.laws import Rate, clipped

SAMPLE, SUBSTEPS = 5e-3, 20
CART, BOB, LENGTH = 1.25, 0.23, 0.5
"""[kg], [kg], [m]"""
VISCOUS, COULOMB, LAG = 1.6, 0.08, 8e-3
"""[N s/m], [N], [s]"""
GRAVITY, MOST_FORCE = 9.80665, 20.0
KV, KW, FILTER_TIME = 8.0, 8.0, 5e-3
"""Gains of the velocities, which stay as they are [N s/m], [N s/rad], and their filter [s]."""
X_COUNT, ANGLE_COUNT = 1e-4, 2.0 * math.pi / 8192


def pendulum(
    gains: Mapping[str, float], reference: Recording, conditions: Conditions
) -> dict[str, Vector]:
    """A longer and heavier pendulum than its twin's.

    Raises
    ------
    Fallen
        The rod lies on the track.
    """
    wanted = reference.signal("reference")
    rows = len(wanted)
    noise = conditions.noise(1e-4, rows), conditions.noise(5e-4, rows)
    speed, spin = Rate(FILTER_TIME, SAMPLE), Rate(FILTER_TIME, SAMPLE)
    x = v = a = w = force = command = 0.0
    h, share = SAMPLE / SUBSTEPS, -math.expm1(-SAMPLE / SUBSTEPS / LAG)
    cart, bob = conditions.inertia * CART, conditions.inertia * BOB
    coulomb, out = conditions.friction * COULOMB, np.empty((3, rows))
    for k, target in enumerate(wanted.tolist()):
        seen = X_COUNT * math.floor((x + noise[0][k]) / X_COUNT + 0.5)
        tilt = ANGLE_COUNT * math.floor((a + noise[1][k]) / ANGLE_COUNT + 0.5)
        out[:, k] = seen, tilt, command
        raw = gains["kx"] * (seen - target) + KV * speed.next(seen)
        raw += gains["ka"] * tilt + KW * spin.next(tilt)
        command = clipped(raw, -MOST_FORCE, MOST_FORCE)
        for _ in range(SUBSTEPS):
            force += share * (command - force)
            s, c = math.sin(a), math.cos(a)
            net = force - VISCOUS * v - coulomb * math.tanh(v / 2e-3)
            push = (net + bob * s * (LENGTH * w * w - GRAVITY * c)) / (cart + bob * s * s)
            w += h * (GRAVITY * s - push * c) / LENGTH
            v += h * push
            x += h * v
            a += h * w
        if abs(a) > 0.5 * math.pi:
            raise Fallen("the pendulum has fallen")
    named = {"position": out[0], "angle": out[1], "force_command": out[2]}
    return {"time": reference.time, "reference": wanted, **named}
