"""A law that is not in the library shows as a free function of the states; noise does not."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.evidence import grams, log_evidences, weightings
from gmfbo.diagnosis.comparison.inadequacy import motion_of, through_loop
from gmfbo.diagnosis.comparison.moves import Move
from gmfbo.diagnosis.comparison.numbers import NAMED, TORQUE_TIME, named_log_odds
from gmfbo.diagnosis.comparison.opened_comparison import comparison_of
from gmfbo.diagnosis.comparison.row_fits import RowFits
from gmfbo.diagnosis.comparison.search import Search
from gmfbo.diagnosis.comparison.unknown.beside import Unknown, _Beside, unknown_beside
from gmfbo.diagnosis.comparison.unknown.curve import DrawnFunction
from gmfbo.diagnosis.comparison.unknown.fitted import WithUnknown, begun_as, fitted_with
from gmfbo.diagnosis.comparison.unknown.kinds import _ticks, kinds
from gmfbo.diagnosis.comparison.whitener import Whitening
from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin.augmented_twin import AugmentedTwin
from tests.diagnosis.noise.planted_noise import STEP, Planted, opened
from tests.diagnosis.short_recordings import SERVO, moves, multisine, triangle

Array = NDArray[np.float64]
DRAGGED = ("torque", "position", 41)
"""Port, state and number of functions of the last kind that has these: times the velocity."""
Torque = Callable[[Array, Array, np.random.Generator], Array]


def rippled_drag(position: Array, velocity: Array, rng: np.random.Generator) -> Array:
    """[N m] Drag that changes over the position."""
    return -0.01 * velocity * np.cos(20.0 * position)


def square_drag(position: Array, velocity: Array, rng: np.random.Generator) -> Array:
    """[N m] Drag in proportion to the square of the velocity."""
    return -2e-4 * velocity * np.abs(velocity)


def cubic_drag(position: Array, velocity: Array, rng: np.random.Generator) -> Array:
    """[N m] Drag in proportion to the cube of the velocity."""
    return -2e-3 * velocity**3


def cubic_spring(position: Array, velocity: Array, rng: np.random.Generator) -> Array:
    """[N m] Return in proportion to the cube of the angle."""
    return -0.2 * position**3


def torque_noise(position: Array, velocity: Array, rng: np.random.Generator) -> Array:
    """[N m] With the correlation time of the table."""
    keep, found = np.exp(-STEP / TORQUE_TIME), np.zeros(position.size)
    white = 0.01 * np.sqrt(1.0 - keep**2) * rng.standard_normal(position.size)
    for k in range(1, position.size):
        found[k] = keep * found[k - 1] + white[k]
    return found


def recordings(torque: Torque) -> Planted:
    """A servo axis on which a torque acts that depends on its own motion."""
    rng, twin = np.random.default_rng(1), SERVO.twin()
    time = STEP * np.arange(1400, dtype=np.float64)
    made, columns = [], []
    with AugmentedTwin(twin, substeps=10, isolated=False) as simulator:
        for k, reference in enumerate((multisine, moves, triangle)):
            asked = Recording(
                time=time,
                signals={SERVO.driven: reference(time)},
                name=f"rec{k}.csv",
                parameters=SERVO.gains,
                written_by="test",
            )
            plan, column = simulator.plan(asked, SERVO.truth), 2e-5 * rng.standard_normal(1400)
            acting, seed = np.zeros(plan.grid.size), int(rng.integers(1000))
            for _ in range(4):  # until the motion is that under its own torque
                pushed = {"sensor": column, "torque": acting}
                run = simulator.run(plan, SERVO.truth, {}, excitation=pushed)
                states = run.states
                acting = torque(states["position"], states["velocity"], np.random.default_rng(seed))
            signals = {**run.held, "position": run.held["position"] + column}
            made.append(
                Recording(
                    time=time,
                    signals={SERVO.driven: reference(time), **signals},
                    name=asked.name,
                    parameters=SERVO.gains,
                    written_by="test",
                )
            )
            columns.append(column)
    return Planted(twin, made, columns)


def left(torque: Torque, effects: Sequence[str] = ()) -> Unknown | None:
    with opened(recordings(torque)) as case:
        stated = comparison_of(case, effects)
        ledger, scored = stated.run()
        return unknown_beside(stated.search, ledger, scored)


@pytest.fixture(scope="module")
def dragged() -> Iterator[Unknown]:
    """What is missing where drag changes over the position; its simulators stay open."""
    with opened(recordings(rippled_drag)) as case:
        stated = comparison_of(case, [])
        found = unknown_beside(stated.search, *stated.run())
        assert found is not None
        yield found


def test_a_law_over_the_position_is_seen_and_its_state_told(dragged: Unknown) -> None:
    assert dragged.probability >= NAMED
    assert dragged.log_odds > 30.0
    assert (dragged.port, dragged.against) == ("torque", "position")


def covered(curve: DrawnFunction, truth: Array) -> float:
    """Share of the points at which the band holds the truth; a hundredth of it is no difference."""
    slack = 0.01 * float(np.abs(truth).max())
    return float(np.mean(np.abs(curve.y - truth) <= curve.half + slack))


def test_the_curve_is_the_law_without_what_parameters_make_of_it(dragged: Unknown) -> None:
    curve, fitted = dragged.function.curve(), dragged.function.fitted
    assert curve is not None
    assert curve.against == "position, in proportion to the velocity (at its largest)"
    fast = motion_of(dragged.function.problem, fitted.left).fast
    truth = -0.01 * fast * np.cos(20.0 * curve.x)
    # The twin's viscous friction is drag as well, the same everywhere.
    weights = curve.half**-2
    truth += weights @ (curve.y - truth) / weights.sum()
    assert covered(curve, truth) >= 0.85
    assert np.corrcoef(curve.y, truth)[0, 1] > 0.98
    assert np.median(curve.half) < 0.2 * np.abs(truth).max()


def test_evidence_is_the_same_however_many_weightings_are_held_at_a_time(
    dragged: Unknown, monkeypatch: pytest.MonkeyPatch
) -> None:
    function = dragged.function
    row = function.fitted.left
    inner = grams(function.problem, row.beside_own_parts(function.whitening), row)
    weights = weightings(len(inner.squares))
    whole = log_evidences(row, inner, weights)
    monkeypatch.setattr("gmfbo.diagnosis.comparison.evidence._MOST_VALUES", 50)
    np.testing.assert_allclose(log_evidences(row, inner, weights), whole, rtol=1e-12)


def test_a_function_of_the_time_is_nothing_where_one_recording_alone_goes_on() -> None:
    passed = [np.linspace(0.0, 1.0, 101), np.linspace(0.0, 0.5, 51), np.linspace(0.0, 0.6, 61)]
    long, short, middle = _ticks(passed, 2.0)
    assert np.any(long[:, 60] != 0.0)
    assert not np.any(long[:, 61:])
    np.testing.assert_allclose(long[:, :61], middle, atol=1e-12)
    np.testing.assert_allclose(long[:, :51], short, atol=1e-12)


def test_what_is_no_function_of_one_state_is_not_drawn_as_one(dragged: Unknown) -> None:
    """The same torque as one of position and velocity, and as one of position alone."""
    function = dragged.function
    kind, row = function.fitted.kind, function.fitted.left
    states = [run.response.states for run in row.runs]
    for port_signals, against in (
        ([s["position"] * s["velocity"] for s in states], "velocity"),
        ([s["velocity"] * np.sin(9.0 * s["position"]) for s in states], "position"),
    ):
        plain = replace(
            kind,
            against=against,
            ways=(("", [np.ones(own.size) for own in port_signals]),),
            signals=[own[None] for own in port_signals],
        )
        columns = [c[:1] for c in function.fitted.columns]
        fitted = replace(function.fitted, kind=plain, columns=columns, amplitudes=np.ones(1))
        assert replace(function, fitted=fitted).curve() is None


def test_a_recording_without_part_in_the_fit_is_foretold(dragged: Unknown) -> None:
    function = dragged.function
    problem, base = function.problem, function.fitted.row
    records = problem.simulations.records
    without = problem.simulations.run([problem.point(base.hypothesis, base.x)])[0]
    for k, record in enumerate(records):
        played = function.played([k])
        assert played is not None
        foretold = played[k]
        before, after = (
            float(np.sum((signal.values - run.signals[i]) ** 2))
            for run in (without[k], foretold)
            for i, signal in enumerate(record.signals)
            if signal.name == "position"
        )
        assert after < 0.3 * before


def test_own_parts_of_a_recording_do_not_foretell_it(dragged: Unknown) -> None:
    """They were read of it: without a part in the fit it is run at the common values."""
    function = dragged.function
    left = function.fitted.left
    shape = (len(function.problem.simulations.records), left.u.size)
    runs = []
    for size in (0.0, 0.5):
        own = np.zeros(shape)
        own[1] = size
        fitted = replace(function.fitted, left=replace(left, own=own))
        played = replace(function, fitted=fitted).played([1])
        assert played is not None
        runs.append(played[1].signals)
    for without, with_own in zip(*runs, strict=True):
        np.testing.assert_array_equal(without, with_own)


@pytest.mark.slow
def test_a_curve_over_the_velocity_has_no_slope_that_friction_makes() -> None:
    with opened(recordings(cubic_drag)) as case:
        stated = comparison_of(case, [])
        found = unknown_beside(stated.search, *stated.run())
    assert found is not None
    curve = found.function.curve()
    assert curve is not None
    assert curve.against == "velocity"
    truth, weights = -2e-3 * curve.x**3, curve.half**-2
    truth += curve.x * (weights @ (curve.x * (curve.y - truth)) / (weights @ curve.x**2))
    # It was fitted along the motion without it: fast, the band is narrower than its errors.
    assert covered(curve, truth) >= 0.7
    assert np.sum((curve.y - truth) ** 2) < 0.01 * np.sum(truth**2)


@pytest.mark.slow
def test_a_law_that_only_imitates_the_unknown_is_not_beside_it() -> None:
    """Friction over the position explains part of a drag that changes over it (draw case 018)."""
    found = left(rippled_drag, ["position_dependent_friction", "viscous_friction"])
    assert found is not None
    assert found.against == "position"
    assert "position_dependent_friction" not in found.beside


@pytest.mark.parametrize(
    ("torque", "effects", "is_promised"),
    [
        (cubic_spring, ["elastic_return", "gravity_torque"], True),
        (square_drag, ["quadratic_drag"], False),
    ],
)
def test_a_free_function_promises_what_laws_do_not_make(
    torque: Torque, effects: Sequence[str], is_promised: bool
) -> None:
    """Two laws leave little of a cubic spring, not much more than noise (draw case 449)."""
    with opened(recordings(torque)) as case:
        stated = comparison_of(case, effects)
        ledger, scored = stated.run()
        promise = _Beside(stated.search, ledger, scored.best).promise
    assert (promise > named_log_odds()) is is_promised
    assert abs(promise - named_log_odds()) > 5.0


def test_a_law_of_the_library_needs_no_unknown() -> None:
    assert left(square_drag, ["quadratic_drag", "coulomb_friction"]) is None


@pytest.mark.slow
def test_a_law_that_is_nearly_the_unknown_does_not_hide_it() -> None:
    """Draw case 007: quadratic drag explains 98 % of a cubic one."""
    found = left(cubic_drag, ["quadratic_drag", "coulomb_friction"])
    assert found is not None
    assert (found.port, found.against) == ("torque", "velocity")


def test_a_law_about_which_nobody_cares_is_not_told() -> None:
    """A hundredth of the rippled drag: far below 1 % of the drive's torque."""
    little = recordings(lambda q, v, rng: 0.01 * rippled_drag(q, v, rng))
    with opened(little) as case:
        stated = comparison_of(case, [])
        ledger, scored = stated.run()
        promise = _Beside(stated.search, ledger, scored.best).promise
    assert promise <= named_log_odds()


def test_noise_of_the_shaft_is_no_law() -> None:
    assert left(torque_noise) is None


def test_a_function_of_its_size_may_have_any_mean() -> None:
    """Else a constant torque beside it is likelier, whatever acts (draw case 447)."""
    with opened(recordings(rippled_drag)) as case:
        search = (stated := comparison_of(case, [])).search
        ledger = search.opened(stated.first)
        made = kinds(search.problem, ledger.kernels, ledger.rows[frozenset()])
    plain = [k for k in made if k.against in ("position", "velocity") and k.ways[0][0] == ""]
    assert len(plain) >= 5
    for kind in plain:
        signals = np.concatenate(kind.signals, axis=1)
        level = np.linalg.lstsq(signals.T, np.ones(signals.shape[1]), rcond=1e-9)[0]
        assert np.allclose(level @ signals, 1.0)
        assert level @ level <= len(kind.ways) + 1e-6  # [standard deviations], squared


def test_a_played_function_is_found_again() -> None:
    """The fitted function is the torque that acted, along each recording."""
    made = recordings(rippled_drag)
    with opened(made) as case:
        search = (stated := comparison_of(case, [])).search
        ledger = search.opened(stated.first)
        base, problem = ledger.rows[frozenset()], search.problem
        quiet = search.noise.cared_about(base, ledger)
        kind = [
            k
            for k in kinds(problem, ledger.kernels, base)
            if (k.port, k.against, k.count) == DRAGGED
        ][-1]
        columns = through_loop(problem, ledger.kernels, kind.port, kind.signals, as_simulated=True)
        start = WithUnknown(kind, columns, base, np.zeros(kind.count))
        found = fitted_with(problem, quiet, base, start, 100.0 * search.tolerance)
        assert_told_by_a_straight_line(search, start, base.beside_own_parts(quiet))
        values = sum(z.size for z in base.residual)
        assert quiet.square(base.residual) > 5.0 * values
        assert quiet.square(found.left.residual) < 1.2 * values
        # What is put back is what the function makes, but for what is no straight line.
        there = problem.simulations.run([problem.point(base.hypothesis, found.left.x)])[0]
        without = problem.residual(problem.values(there), found.left.nuisances)
        change = [a - b for a, b in zip(found.row.residual, without, strict=True)]
        assert quiet.square(change) < 0.01 * quiet.square(without)
        for signals, run in zip(found.kind.signals, found.left.runs, strict=True):
            states = run.response.states
            acting = rippled_drag(states["position"], states["velocity"], np.random.default_rng(0))
            # Inertia and friction of the twin take what they can of it.
            speed, played = states["velocity"], found.amplitudes @ signals
            known = np.stack([played, speed, np.gradient(speed)], axis=1)
            left = acting - known @ np.linalg.lstsq(known, acting, rcond=None)[0]
            assert np.std(left) < 0.1 * np.std(acting)


def assert_told_by_a_straight_line(
    search: Search, start: WithUnknown, whitening: Whitening
) -> None:
    """Amplitudes are those of ridge regression, each quantity held by its prior."""
    row, once = start.left, np.ones((1, sum(len(own) for own in search.problem.stretches())))
    sized = start.sized(search.problem, whitening, once, search.tolerance)
    made = np.concatenate(start.blocks(whitening), axis=1)
    left = np.concatenate([z.ravel() for z in whitening(row.residual)])
    free = np.full(start.kind.count, sized.size**-2)
    ridge = np.diag(np.sqrt(np.concatenate([row.curvatures, free])))
    pull = np.concatenate([-row.slopes / np.sqrt(row.curvatures), 0.0 * free])
    values = np.linalg.lstsq(
        np.concatenate([made.T, ridge]), np.concatenate([left, pull]), rcond=None
    )[0]
    straight = replace(start, amplitudes=values[-start.kind.count :])
    told = replace(start, amplitudes=sized.amplitudes)
    assert told.effective == pytest.approx(straight.effective, rel=1e-6)


def test_a_larger_row_begins_where_a_function_ended_with_nothing_of_its_law() -> None:
    with opened(recordings(rippled_drag)) as case:
        search = (stated := comparison_of(case, ["coulomb_friction"])).search
        ledger = search.opened(stated.first)
        base, problem = ledger.rows[frozenset()], search.problem
        quiet = search.noise.cared_about(base, ledger)
        kind = kinds(problem, ledger.kernels, base)[0]
        columns = through_loop(problem, ledger.kernels, kind.port, kind.signals, as_simulated=True)
        start = WithUnknown(kind, columns, base, np.zeros(kind.count))
        ended = fitted_with(problem, quiet, base, start, 100.0 * search.tolerance)
        assert np.abs(ended.amplitudes).max() > 0.0
        move = Move(next(e for e in search.elements if e.name == "coulomb_friction"), np.inf)
        rows = RowFits(problem, ledger.noise_of).with_moves(ledger, base, [move])
        begun = begun_as(problem, rows[frozenset({"coulomb_friction"})], ended)
        assert begun is not None
        assert begun.left.elements == {"coulomb_friction"}
        np.testing.assert_array_equal(begun.amplitudes, ended.amplitudes)
        for now, then in zip(begun.left.residual, ended.left.residual, strict=True):
            np.testing.assert_allclose(now, then, atol=1e-3 * np.abs(then).max())
