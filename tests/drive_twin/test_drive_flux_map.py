"""The flux map of the FMU, seen from outside.

A flywheel turns the motor at constant speed w_e; once its currents are steady the voltages give
the fluxes: psi_d = (v_q - R i_q) / w_e and psi_q = -(v_d - R i_d) / w_e.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from gmfbo.sources.fmu_file.models import models_folder
from tests.drive_twin.drive_runs import CORNERS, IDEAL_ENCODERS, NO_FRICTION, NO_RIPPLE, Drive
from tests.drive_twin.flux_map import (
    HALF_WIDTH,
    MAGNETS,
    NODES,
    SPACING,
    currents,
    formula,
    linear_table,
    map_deltas,
    noise_table,
    nominal_table,
    with_ghosts,
)

RESISTANCE, SPEED = 0.1, 5.0  # [Ohm], [rad/s] at the joint
ELECTRICAL_SPEED = 10 * 9 * SPEED  # [rad/s]
FLYWHEEL = {
    "load.inertia": 1000.0,
    "initial.velocity": SPEED,
    "drive.voltage": 200.0,
    "ctl.delay": 0.0,
    **NO_FRICTION,
    **NO_RIPPLE,
    **IDEAL_ENCODERS,
}


def steady(
    drive: Drive, torque: float, parameters: dict[str, float]
) -> tuple[float, float, NDArray[np.float64]]:
    """Fluxes u and w [Wb], and currents [A], shape (2,); a brake takes up the torque."""
    run = drive.run(
        {**FLYWHEEL, **parameters},
        gains=(0.0, 0.0),
        duration=0.3,
        torque_reference=torque,
        tau_load=-torque,
    )
    i_d, i_q, v_d, v_q = (run.signal(name)[-1] for name in ("i_d", "i_q", "v_d", "v_q"))
    speed = ELECTRICAL_SPEED * run.signal("velocity")[-1] / SPEED
    u = (v_q - RESISTANCE * i_q) / speed - MAGNETS
    return u, -(v_d - RESISTANCE * i_d) / speed, np.array([i_d, i_q])


@pytest.mark.parametrize("torque", [-40.0, -8.0, 0.0, 3.0, 25.0, 45.0])
def test_the_nominal_map_is_its_formula_up_to_a_cell_from_the_edge(
    drive: Drive, torque: float
) -> None:
    u, w, measured = steady(drive, torque, {})
    assert max(abs(u), abs(w)) < HALF_WIDTH - SPACING
    np.testing.assert_allclose(measured, formula(np.array(u), np.array(w)), atol=2e-6)


def test_the_map_near_its_edge_is_the_spline_with_linear_ghosts(drive: Drive) -> None:
    u, w, measured = steady(drive, 60.0, {})
    assert w > HALF_WIDTH - SPACING
    np.testing.assert_allclose(measured, currents(with_ghosts(nominal_table()), u, w), atol=2e-6)


@settings(max_examples=20)
@given(st.integers(0, 2**31 - 1), st.floats(0.01, 0.1), st.floats(-40.0, 40.0))
def test_noise_is_drawn_as_documented(drive: Drive, seed: int, noise: float, torque: float) -> None:
    """Up to a tenth of the range, where the current loop is steady on any draw."""
    u, w, measured = steady(drive, torque, {"map.noise": noise, "map.seed": seed})
    padded = with_ghosts(nominal_table())
    padded[:, 4:-4, 4:-4] += noise_table(noise, seed)
    np.testing.assert_allclose(measured, currents(padded, u, w), atol=1e-5)


def test_noise_has_the_stated_deviation() -> None:
    """Over 200 seeds: relative standard error of a deviation 1/sqrt(2 n) = 0.7 %, 5 of them."""
    drawn = np.stack([noise_table(0.5, seed) for seed in range(200)], axis=1)
    spread = drawn.reshape(2, -1).std(axis=1) / np.ptp(nominal_table(), axis=(1, 2))
    np.testing.assert_allclose(spread, 0.5, rtol=0.036)
    assert abs(np.asarray(np.corrcoef(drawn.reshape(2, -1)))[0, 1]) < 5.0 / np.sqrt(drawn[0].size)


@pytest.mark.parametrize("node", [(3, 3), (3, 4), (2, 3), (4, 5), (5, 5)])
@pytest.mark.parametrize("axis", ["d", "q"])
def test_a_delta_adds_to_its_node(drive: Drive, axis: str, node: tuple[int, int]) -> None:
    u, w, measured = steady(drive, 20.0, {f"map.delta_{axis}[{node[0]},{node[1]}]": 2.0})
    padded = with_ghosts(nominal_table())
    padded[("d", "q").index(axis), 3 + node[0], 3 + node[1]] += 2.0
    np.testing.assert_allclose(measured, currents(padded, u, w), atol=2e-6)


def test_deltas_can_take_back_the_noise(drive: Drive) -> None:
    noisy = {"map.noise": 0.5, "map.seed": 7}
    corrected = drive.run({**noisy, **map_deltas(-noise_table(0.5, 7))})
    nominal, uncorrected = drive.run(), drive.run(noisy)
    apart = np.abs(corrected.signal("true_position") - nominal.signal("true_position"))
    assert apart[:300].max() < 1e-6
    assert np.abs(uncorrected.signal("i_d") - nominal.signal("i_d")).max() > 0.1


def test_deltas_can_make_the_map_linear(drive: Drive) -> None:
    flat = map_deltas(linear_table() - nominal_table())
    u, w, measured = steady(drive, 30.0, flat)
    assert max(abs(u), abs(w)) < HALF_WIDTH - SPACING
    np.testing.assert_allclose(measured, [u / 3.0e-4, w / 3.6e-4], atol=2e-6)


def test_without_noise_the_seed_does_not_matter(drive: Drive) -> None:
    nominal, seeded = drive.run(), drive.run({"map.noise": 0.0, "map.seed": 12345})
    for name in nominal.signals:
        np.testing.assert_array_equal(nominal.signal(name), seeded.signal(name), err_msg=name)


@pytest.mark.parametrize("gains", CORNERS)
def test_runs_are_finite_at_75_percent_noise(drive: Drive, gains: tuple[float, float]) -> None:
    for seed in range(20):
        run = drive.run({"map.noise": 0.75, "map.seed": seed}, gains=gains)
        assert all(np.isfinite(signal).all() for signal in run.signals.values()), seed


def test_both_models_carry_the_table_that_the_script_makes() -> None:
    root = models_folder().parent / "fmu_build"
    texts = [
        (root / model / "resources" / "flux_map.txt").read_text(encoding="ascii")
        for model in ("drive_twin", "drive_plant")
    ]
    assert texts[0] == texts[1]
    words = " ".join(line for line in texts[0].splitlines() if not line.startswith("#")).split()
    assert int(words[0]) == NODES
    assert int(words[1]) * 1e-12 == pytest.approx(HALF_WIDTH)
    table = np.array(words[2:], dtype=float).reshape(2, NODES, NODES) * 1e-9
    np.testing.assert_allclose(table, nominal_table(), atol=1e-8)
