"""Excitations and trajectories that the tests of effects share."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray

from gmfbo.physics import Excitation, States

TYPICAL = Excitation(
    torque=9.0,
    command=9.0,
    command_rate=400.0,
    current=9.0,
    speed=10.0,
    stroke=3.0,
    resolution=1e-4,
    duration=2.5,
    total=10.0,
    sample=1e-3,
    step=1e-4,
    loop_time=0.03,
    inertia=0.12,
    angular=True,
    reversals=5,
)
LINEAR = replace(TYPICAL, angular=False, stroke=0.2, speed=0.5, resolution=1e-6, inertia=95.0)


def clock(count: int, step: float) -> NDArray[np.float64]:
    """Times of `count` samples from zero, `step` apart [s]."""
    return np.arange(count, dtype=np.float64) * np.float64(step)


def swing(seconds: float = 2.0, step: float = 1e-3) -> States:
    """Make a smooth trajectory with reversals, a command apart from it, and no noise."""
    time = clock(round(seconds / step), step)
    slow, fast = 2.0 * math.pi * 0.7, 2.0 * math.pi * 2.3
    position = np.sin(slow * time) + 0.2 * np.sin(fast * time)
    velocity = slow * np.cos(slow * time) + 0.2 * fast * np.cos(fast * time)
    command = 6.0 * np.cos(2.0 * math.pi * 3.0 * time) + 2.0 * np.sin(2.0 * math.pi * 11.0 * time)
    return States(time, position, velocity, command, command)


@st.composite
def excitations(draw: st.DrawFn) -> Excitation:
    """Draw what recordings may show: sizes from micrometres to turns, milliseconds to seconds."""

    def decades(low: float, high: float) -> float:
        return float(10.0 ** draw(st.floats(low, high)))

    stroke, loop_time, command = decades(-3, 2), decades(-3, 0.5), decades(-2, 3)
    torque, sample = decades(-3, 4), loop_time * decades(-2.5, -0.5)
    speed, duration = stroke / loop_time * decades(-2, 0.3), loop_time * decades(1.3, 3.5)
    inertia = torque * loop_time / speed * decades(-1.5, 1.0) if draw(st.booleans()) else None
    lines = st.lists(st.floats(3.0, 60.0), max_size=6)
    return Excitation(
        torque=torque,
        command=command,
        command_rate=command / loop_time * decades(-1, 2.5),
        current=decades(-2, 3),
        speed=speed,
        stroke=stroke,
        resolution=stroke * decades(-7, -3.3),
        duration=duration,
        total=duration * draw(st.integers(1, 9)),
        sample=sample,
        step=sample / draw(st.sampled_from((1, 10))),
        loop_time=loop_time,
        inertia=inertia,
        angular=draw(st.booleans()),
        reversals=draw(st.integers(0, 50)),
        wavenumbers=tuple(2.0 * math.pi / stroke * cycles for cycles in draw(lines)),
        frequencies=tuple(cycles / duration for cycles in draw(lines)),
        pulses=((0.0, 0.5 * sample), (0.9 * duration, duration)) if draw(st.booleans()) else (),
    )
