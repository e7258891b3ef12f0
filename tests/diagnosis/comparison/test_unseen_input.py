"""What an input did between its rows is as uncertain as a step there, and acts as the twin says."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo import FmuTwin, Recording, diagnose
from gmfbo.diagnosis.case.open_case import open_case
from gmfbo.diagnosis.checking.two_readings import straight
from gmfbo.diagnosis.comparison.noise.unseen_input import error_over_rows, unseen_input
from gmfbo.diagnosis.comparison.opened_comparison import comparison_of
from gmfbo.diagnosis.comparison.port_kernels import port_kernels
from gmfbo.diagnosis.runs.scored_record import Record, scored_record
from gmfbo.diagnosis.runs.simulated import Point
from gmfbo.diagnosis.runs.simulations import Simulations
from gmfbo.physics import CATALOGUE
from gmfbo.sources.twin.augmented_twin import AugmentedTwin
from tests.diagnosis.short_recordings import BENCH, SERVO

Run = Callable[[NDArray[np.float64]], NDArray[np.float64]]

ROW, STEPS = 0.01, 10  # [s] From row to row, and steps of the twin


def test_a_straight_line_misses_a_step_at_any_instant_by_so_much_of_it() -> None:
    """Of a step at the share f of a row the mean is 1 - f of it, of the line a half."""
    shares = (np.arange(100_000) + 0.5) / 100_000
    missed = np.sqrt(np.mean((1.0 - shares - 0.5) ** 2))
    found = error_over_rows(np.array([0.5, 0.5, 3.5, -0.5]))
    np.testing.assert_allclose(found, [0.0, 3.0 * missed, 4.0 * missed], rtol=1e-8)


def test_a_path_of_independent_increments_is_missed_as_much() -> None:
    """Wide of 2 %: the mean of 40,000 squares has a standard error of 0.9 %."""
    rng = np.random.default_rng(0)
    paths = np.cumsum(rng.standard_normal((40_000, 200)), axis=1) / np.sqrt(200.0)
    missed = paths.mean(1) - 0.5 * paths[:, -1]
    told = error_over_rows(np.array([0.0, 1.0]))[0]  # of a change of one, the increments' spread
    assert np.sqrt(np.mean(missed**2)) == pytest.approx(told, rel=0.02)


def bench_record(twin: FmuTwin, pushed: int | None = None, by: float = 0.0) -> Record:
    """A row of steps of the current; one of its rows may be pushed, held for that row."""
    time = ROW / STEPS * np.arange(80 * STEPS, dtype=np.float64)
    rows = 0.5 * np.random.default_rng(1).standard_normal(80)
    current = np.interp(time, ROW * np.arange(80), rows)
    if pushed is not None:
        current[pushed * STEPS : (pushed + 1) * STEPS] += by
    signals = {"current": current, "position": np.zeros(time.size)}
    if pushed is None:
        signals = {name: column[::STEPS] for name, column in signals.items()}
        time = time[::STEPS]
    recording = Recording(time=time, signals=signals, name="steps.csv")
    with AugmentedTwin(twin, substeps=5, isolated=False) as simulator:
        return scored_record(recording, simulator.plan(recording, {}), ["position"], 0.0)


def test_it_makes_of_the_signals_what_the_twin_makes_of_another_input_in_that_row() -> None:
    twin = straight(BENCH.twin(), ["current"])
    record, row = bench_record(twin), 45  # answers are as long as half a recording
    with Simulations(lambda: AugmentedTwin(twin, substeps=5), [record], 1) as simulations:
        kernels = port_kernels(simulations, Point(), {"command": 1.0}, "position", 1.0, None)
        errors = unseen_input(record, kernels)
        assert errors is not None
        size = error_over_rows(record.plan.recording.signal("current"))[row]
        fine = [bench_record(twin, row, by) for by in (0.0, size)]
        simulations.replace_records(fine[:1])
        before = simulations.run_one(Point(), 0).signals[0]
        simulations.replace_records(fine[1:])
        after = simulations.run_one(Point(), 0).signals[0]
    change = (after - before)[::STEPS]
    assert errors[0].shape == (79, 80)
    # Driven straight at the finer rows, the ends of the push are half a step sooner.
    np.testing.assert_allclose(errors[0][row], change, atol=0.06 * np.abs(change).max())


def test_an_input_that_is_held_is_known_and_so_is_the_reference_of_a_loop() -> None:
    twin = BENCH.twin()
    record = bench_record(twin)
    with Simulations(lambda: AugmentedTwin(twin, substeps=5), [record], 1) as simulations:
        kernels = port_kernels(simulations, Point(), {"command": 1.0}, "position", 1.0, None)
        assert unseen_input(record, kernels) is None
    servo = SERVO.twin()
    recording = SERVO.recordings({}, seconds=0.8)[0]
    with AugmentedTwin(servo, substeps=5, isolated=False) as simulator:
        of_loop = scored_record(recording, simulator.plan(recording, {}), ["position"], 0.0)
    loop = replace(kernels, simulated={"command": {"position": np.ones(10)}})
    assert unseen_input(of_loop, loop) is None


def straight_path(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """[A] Straight from row to row."""
    values = 0.4 * np.random.default_rng(2).choice([-1.0, 0.0, 1.0], 400)
    return np.interp(t, 2.0 * ROW * np.arange(400), values)


def stepping_path(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """[A] Steps at any instant between rows."""
    rng = np.random.default_rng(2)
    steps = 2.0 * ROW * (5.0 * np.arange(80) + rng.random(80))
    values = 0.4 * rng.choice([-1.0, 1.0], 81)
    return np.asarray(values[np.searchsorted(steps, t)], dtype=np.float64)


def in_slow_rows(run: Run) -> Recording:
    """Four seconds of the bench, in rows twice as slow."""
    fine = BENCH.recordings({}, (run,), seconds=4.0)[0]
    signals = {name: column[:: 2 * STEPS] for name, column in fine.signals.items()}
    return replace(fine, time=fine.time[:: 2 * STEPS], signals=signals, written_by="")


@pytest.mark.parametrize(("run", "missed"), [(straight_path, False), (stepping_path, True)])
def test_errors_of_an_input_stay_where_it_did_not_go_straight(run: Run, missed: bool) -> None:
    twin = straight(BENCH.twin(), ["current"])
    case = open_case(twin, [in_slow_rows(run)], seed=0, jobs=1)
    try:
        comparison = comparison_of(case, ())
        ledger = comparison.search.opened(comparison.first)
        assert bool(ledger.errors.between) is missed
        assert ledger.rows[frozenset()].parameters["inertia"] == pytest.approx(0.0052, rel=0.05)
    finally:
        case.simulations.close()


def test_the_floor_of_the_table_has_what_they_made() -> None:
    """Without them it is a tenth of the error, and half of it with them: bumps have the rest."""
    twin, known = straight(BENCH.twin(), ["current"]), [in_slow_rows(stepping_path)]
    asked = {"coulomb_friction", "actuator_lag"}
    told = diagnose(twin, known, exclude=sorted(set(CATALOGUE) - asked), seed=0, jobs=1)
    assert told.effects == ()
    error = told.fit.signals["position"]
    assert 0.4 < error.noise_floor / error.parameters_only < 1.2
