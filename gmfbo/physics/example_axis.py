"""The axis at which sizes of effects are told where no recording is at hand."""

from __future__ import annotations

from gmfbo.physics.excitation import Excitation

EXAMPLE_AXIS = Excitation(
    torque=10.0,
    command=10.0,
    command_rate=1000.0,
    current=10.0,
    speed=5.0,
    stroke=1.0,
    resolution=1e-5,
    duration=2.5,
    total=10.0,
    sample=1e-3,
    step=2e-4,
    loop_time=0.02,
    inertia=0.01,
    angular=True,
    reversals=10,
)
"""A motor shaft of 10 N.m; `notebooks/docs/effects.md` describes it."""
