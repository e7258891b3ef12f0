"""What the new nulls do to recordings, each against what it must be."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gmfbo import FmuTwin, Recording
from tests.blind.draw.rich import rich_machine
from tests.blind.draw.rigs import Rig, coloured, record_with
from tests.blind.machines import SERVO, Knowledge, Machine, twin_file, variation
from tests.blind.oracle import Experiment
from tests.blind.recording import Logger, record
from tests.blind.references import SHAPES
from tests.blind.truth import PREROLL, SAMPLE, Vector, simulate

QUIET = replace(SERVO, jitter=0.0, quantum=0.0, command_noise=0.0)
"""The servo without any noise."""


def experiment(rows: int = 800, size: float = 0.8) -> Experiment:
    """A motion of the servo at its own gains."""
    reference = size * SHAPES["multisine"](np.random.default_rng(1), rows)
    return Experiment("multisine", reference, {"kp": 40.0, "kd": 0.8})


def columns(rig: Rig, machine: Machine = QUIET, convention: str = "held") -> tuple[Vector, Vector]:
    """Logged position and command of one run."""
    rng = np.random.default_rng(3)
    one = experiment()
    values = {**machine.truth, **one.gains}
    text = record_with(rig, machine, values, one, Logger(convention), rng)
    rows = [line.split(",") for line in text.splitlines() if line[0] not in "#t"]
    table = np.array(rows, dtype=float)
    return table[:, 2], table[:, 3]


def test_with_nothing_wrong_a_rig_is_the_recording_of_the_blind_benchmark() -> None:
    one = experiment()
    values = {**SERVO.truth, **one.gains}
    usual = record(SERVO, values, one, Logger("held"), np.random.default_rng(3))
    rig = record_with(Rig(), SERVO, values, one, Logger("held"), np.random.default_rng(3))
    written = [[line.split(",")[:3] for line in text.splitlines()] for text in (usual, rig)]
    assert written[0] == written[1]  # time, reference and position; noise of the command is new


def test_noise_of_the_logger_stays_out_of_the_loop() -> None:
    position, command = columns(Rig())
    noisy, same = columns(Rig(position_noise=1e-4))
    assert np.array_equal(command, same)
    assert np.std(noisy - position) == pytest.approx(1e-4, rel=0.15)


def test_control_noise_of_the_encoder_goes_round_the_loop() -> None:
    _, command = columns(Rig())
    _, other = columns(Rig(), replace(QUIET, jitter=1e-4))
    assert np.std(other - command) > 1e-3


def test_a_clean_loop_reads_neither_noise_nor_counts() -> None:
    loud = replace(QUIET, jitter=1e-4, quantum=1e-3)
    assert np.array_equal(columns(Rig(loop_is_clean=True), loud)[1], columns(Rig())[1])


def test_a_coarse_logger_writes_whole_counts_within_half_a_count() -> None:
    position, command = columns(Rig())
    coarse, steps = columns(Rig(position_count=2e-3, command_count=0.05))
    for rounded, true, count in ((coarse, position, 2e-3), (steps, command, 0.05)):
        assert np.max(np.abs(rounded / count - np.round(rounded / count))) < 1e-6
        assert np.max(np.abs(rounded - true)) <= 0.5 * count * (1.0 + 1e-6)


def test_jitter_moves_the_position_by_speed_times_time() -> None:
    position, command = columns(Rig())
    moved, same = columns(Rig(jitter=3e-4))
    assert np.array_equal(command, same)
    speed = np.abs(np.gradient(position, SAMPLE))
    assert np.all(np.abs(moved - position) <= 3.3e-4 * speed + 2e-5)
    assert np.std(moved - position) > 1e-5


def test_jitter_of_rows_takes_the_old_command_or_the_new_one() -> None:
    held, new = columns(Rig())[1], columns(Rig(), convention="new")[1]
    mixed = columns(Rig(jitter=3e-4, jitters_command=True))[1]
    assert np.all((mixed == held) | (mixed == new))
    changed = held != new
    assert 0.3 < np.mean(mixed[changed] == new[changed]) < 0.7


@pytest.mark.parametrize("column", ["position", "command"])
def test_a_low_pass_delays_its_column_by_its_time_constant_and_leaves_the_other(
    column: str,
) -> None:
    position, command = columns(Rig())
    filtered = dict(
        zip(("position", "command"), columns(Rig(low_pass=2e-3, filtered=column)), strict=True)
    )
    plain = {"position": position, "command": command}
    other = "command" if column == "position" else "position"
    assert np.array_equal(filtered[other], plain[other])
    # y' = (x - y) / T: what is left of x after y + T y' is of the second order in the sample
    rate = np.diff(filtered[column]) / SAMPLE
    rebuilt = filtered[column][1:] + (2e-3 - 0.5 * SAMPLE) * rate
    assert np.std(rebuilt - plain[column][1:]) < 0.1 * np.std(filtered[column] - plain[column])


def test_coloured_noise_has_unit_variance_and_half_its_power_at_the_corner() -> None:
    """Two million samples: the standard error of the variance is below 1 %, of the ratio 3 %."""
    noise = coloured(2_000_000, SAMPLE, 10.0, np.random.default_rng(0))
    assert np.var(noise) == pytest.approx(1.0, rel=0.03)
    power = np.mean(np.abs(np.fft.rfft(noise.reshape(-1, 10_000), axis=1)) ** 2, axis=0)
    frequency = np.fft.rfftfreq(10_000, SAMPLE)
    low = power[(frequency > 0.2) & (frequency < 1.0)].mean()
    corner = power[(frequency > 9.5) & (frequency < 10.5)].mean()
    assert corner / low == pytest.approx(0.5, rel=0.1)


def test_a_constant_load_is_a_constant_push() -> None:
    one = experiment()
    pushed = simulate({**SERVO.truth, "push": 0.3}, one.reference)
    loaded = simulate(SERVO.truth, one.reference, load=np.full(PREROLL + 800, 0.3))
    assert np.max(np.abs(pushed.position - loaded.position)) < 1e-12


def test_torque_noise_moves_the_axis_and_its_command() -> None:
    position, command = columns(Rig())
    shaken, other = columns(Rig(load=0.1, load_corner=10.0))
    assert np.std(shaken - position) > 5e-4
    assert 0.03 < np.std(other - command) < 0.3


def test_a_millisecond_is_the_period_unless_another_is_given() -> None:
    one = experiment()
    usual = simulate(SERVO.truth, one.reference)
    told = simulate({**SERVO.truth, "sample": SAMPLE}, one.reference)
    assert np.array_equal(usual.position, told.position)


def test_a_fast_controller_is_that_of_a_twin_whose_sample_time_is_as_short(tmp_path: Path) -> None:
    machine = replace(SERVO, fixed={**SERVO.fixed, "sample": "sample_time"})
    values = {**variation(machine, np.random.default_rng(7)), "sample": SAMPLE / 4.0}
    path = tmp_path / "twin.toml"
    path.write_text(twin_file(machine, Knowledge(values), tmp_path), encoding="utf-8")
    reference = experiment().reference
    true = simulate(values, np.repeat(reference, 4))
    slow = simulate({**values, "sample": SAMPLE}, reference)
    with FmuTwin(path) as twin:
        time = np.asarray(np.arange(800) * SAMPLE, dtype=float)
        run = twin.run({}, Recording(time, {"reference": reference}))
    error = np.max(np.abs(run.signal("position") - true.position[::4]))
    assert error < 1e-9 * np.ptp(true.position)
    assert np.max(np.abs(run.signal("position") - slow.position)) > 1e4 * error


def test_an_averaging_logger_writes_the_mean_of_the_last_four() -> None:
    values = {**QUIET.truth, "kp": 40.0, "kd": 0.8, "sample": SAMPLE / 4.0}
    fast = simulate(values, np.repeat(experiment().reference, 4))
    decimated, _ = columns(Rig(rate=4))
    averaged, _ = columns(Rig(rate=4, averages=True))
    assert np.allclose(decimated, fast.position[::4], atol=1e-8)
    assert averaged[100] == pytest.approx(np.mean(fast.position[397:401]), abs=1e-8)


@pytest.mark.slow
def test_the_rich_axis_is_its_truth_where_their_fifteen_parameters_are(tmp_path: Path) -> None:
    machine = rich_machine(tmp_path)
    assert len(machine.uncertain) == 15
    values = {k: v * 1.07 for k, v in variation(machine, np.random.default_rng(7)).items()}
    values |= {"kind": 1.0, "wave_number_1": 12.0}
    path = tmp_path / "twin.toml"
    path.write_text(twin_file(machine, Knowledge(values), tmp_path), encoding="utf-8")
    reference = experiment().reference
    true = simulate(values, reference)
    with FmuTwin(path) as twin:
        time = np.asarray(np.arange(800) * SAMPLE, dtype=float)
        run = twin.run({}, Recording(time, {"reference": reference}))
    error = np.abs(run.signal("position") - true.position)
    assert np.max(error) < 1e-9 * np.ptp(true.position)
