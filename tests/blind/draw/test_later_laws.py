"""The laws outside the library that came later, each against a closed form."""

from __future__ import annotations

import numpy as np
import pytest

from tests.blind.truth import KINDS, SAMPLE, simulate

INERTIA = 0.01
FREE = {"kind": KINDS["none"], "inertia": INERTIA, "torque_gain": 1.0}


def test_cubic_drag_ends_at_the_speed_where_it_takes_the_whole_torque() -> None:
    run = simulate(FREE | {"cubic_drag": 2e-3}, np.full(3000, 0.4), preroll=0)
    assert run.velocity[-1] == pytest.approx((0.4 / 2e-3) ** (1.0 / 3.0), rel=1e-6)


def test_rippled_drag_takes_energy_by_place() -> None:
    """J dv/dq = -c sin(N q): the speed falls by c (1 - cos N q) / (N J), whatever it is."""
    push = np.where(np.arange(600) < 50, 0.5, 0.0)
    run = simulate(FREE | {"rippled_drag": 0.02, "rippled_drag_number": 3.0}, push, preroll=0)
    plain = simulate(FREE, push, preroll=0)
    after = slice(60, None)
    lost = (
        0.02 / 3.0 / INERTIA * (np.cos(3.0 * run.position[60]) - np.cos(3.0 * run.position[after]))
    )
    np.testing.assert_allclose(run.velocity[60] - run.velocity[after], lost, atol=1e-6)
    assert np.ptp(plain.velocity[after]) < 1e-12


def test_a_sweep_pushes_as_its_phase_says() -> None:
    sweep = {"sweep": 0.1, "sweep_frequency": 2.0, "sweep_rate": 4.0, "sweep_phase": 0.3}
    run = simulate(FREE | sweep, np.zeros(1000), preroll=0)
    t = np.arange(0.0, 1.0, 1e-5)
    torque = 0.1 * np.sin(2.0 * np.pi * (2.0 * t + 2.0 * t**2) + 0.3)
    speed = np.concatenate([[0.0], np.cumsum(0.5 * (torque[1:] + torque[:-1])) * 1e-5 / INERTIA])
    np.testing.assert_allclose(run.velocity, speed[::100][:1000], atol=1e-5)


def test_play_of_the_drive_passes_what_is_beyond_half_of_it_and_holds_on_the_way_back() -> None:
    command = np.concatenate([np.full(20, 0.3), np.full(20, 0.15), np.full(20, -0.3)])
    run = simulate(FREE | {"drive_play": 0.2}, command, preroll=0)
    torque = np.diff(run.velocity) / SAMPLE * INERTIA
    np.testing.assert_allclose(torque[:19], 0.2, rtol=1e-9)
    np.testing.assert_allclose(torque[20:39], 0.2, rtol=1e-9)
    np.testing.assert_allclose(torque[40:59], -0.2, rtol=1e-9)
