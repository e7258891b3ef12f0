"""Location: part of the loop, state and times, of named effects and of mismatches without one."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.fit import Fitted, fit
from gmfbo.diagnosis.fitting.hypothesis import Candidate, Hypothesis
from gmfbo.diagnosis.locating.latent_state import rank_states
from gmfbo.diagnosis.locating.mismatch_place import locate, located_at
from gmfbo.diagnosis.locating.parities import Parities, parities
from gmfbo.diagnosis.locating.times_of_mismatch import (
    Stretch,
    moving_parts,
    strongest,
    time_windows,
)
from gmfbo.diagnosis.result.whereabouts import Location
from gmfbo.diagnosis.runs.measured_excitation import states_of
from gmfbo.physics import States, Units
from tests.diagnosis.servo_recordings import opened

UNITS = Units(torque="N.m", position="rad", velocity="rad/s", command="N.m", current="N.m")


@contextmanager
def hidden(physics: Mapping[str, float]) -> Iterator[Case]:
    case = opened(physics)
    try:
        yield case
    finally:
        case.simulations.close()


def fitted_with(case: Case, candidate: Candidate) -> Fitted:
    found = fit(case.misfit, Hypothesis(case.setting, (candidate,)), case.base.parameters)
    assert found is not None
    return found


def named(case: Case, name: str, **values: float) -> Location:
    whole = fitted_with(case, Candidate(name, values))
    nothing = Parities(None, None, None, {})
    return locate(case, case.base, nothing, whole.hypothesis.effects, whole, UNITS)


def unnamed(case: Case) -> Location:
    return locate(case, case.base, parities(case, case.base), (), None, UNITS)


def overlap(location: Location, recording: str, start: float, end: float) -> float:
    """Time [s] that a location's windows share with a stretch."""
    own = [w for w in location.times if w.recording == recording]
    return sum(max(0.0, min(w.end, end) - max(w.start, start)) for w in own)


def test_nothing_missing_is_nowhere(right_case: Case) -> None:
    assert unnamed(right_case) == Location(None)


def test_pulse_is_found_in_time_with_and_without_its_name() -> None:
    physics = {"start": 1.0, "duration": 0.2, "level": 0.3}
    with hidden({f"pulse_disturbance.{n}": v for n, v in physics.items()}) as case:
        with_name = named(case, "pulse_disturbance", start=0.98, duration=0.22, level=0.2)
        without = unnamed(case)
    assert with_name.signal_path == without.signal_path == "plant"
    assert "time" in with_name.region
    assert "time" in without.region
    for k in range(3):
        assert overlap(with_name, f"rec{k}.csv", 1.0, 1.2) > 0.15
        assert overlap(with_name, f"rec{k}.csv", 0.0, 2.0) < 0.25
        assert overlap(without, f"rec{k}.csv", 1.0, 1.25) > 0.1


def test_friction_is_shown_around_reversals() -> None:
    with hidden({"coulomb_friction.level": 0.06}) as case:
        location = named(case, "coulomb_friction", level=0.05)
        names = [r.name for r in case.simulations.records]
        near = {
            name: (s.time, s.near_reversals(0.06))
            for name, s in zip(
                names,
                map(states_of, case.base.simulated, case.simulations.records),
                strict=True,
            )
        }
    assert location.signal_path == "plant"
    assert location.region == "where the velocity changes sign"
    assert 0 < len(location.times) <= 12
    for window in location.times:
        time, reversal = near[window.recording]
        assert reversal[(time >= window.start) & (time <= window.end)].mean() > 0.7


def test_saturation_is_shown_where_the_command_is_beyond_it() -> None:
    with hidden({"actuator_saturation.limit": 2.0}) as case:
        location = named(case, "actuator_saturation", limit=2.0)
        commands = {
            r.name: (r.signals[1].time, np.abs(r.signals[1].values))
            for r in case.simulations.records
        }
    assert location.signal_path == "actuator"
    assert "command" in location.region
    assert location.times
    for window in location.times:
        time, command = commands[window.recording]
        inside = (time > window.start - 0.02) & (time < window.end + 0.02)
        assert command[inside].max() > 1.9


def test_gravity_is_everywhere_that_the_axis_moves() -> None:
    with hidden({"gravity_torque.sine": 0.15}) as case:
        with_name = named(case, "gravity_torque", sine=0.1, cosine=0.0)
        without = unnamed(case)
    assert {w.recording for w in with_name.times} == {"rec0.csv", "rec1.csv", "rec2.csv"}
    assert overlap(with_name, "rec0.csv", 0.0, 2.0) > 1.5
    assert without.signal_path == "plant"
    assert "position" in without.region


def test_a_free_function_tells_the_part_of_the_loop_that_parities_do_not() -> None:
    assert located_at(Location(None), "sensor", "position").signal_path == "sensor"
    assert located_at(Location(None), "torque", "velocity").signal_path == "plant"
    assert located_at(Location("controller"), "sensor", "position").signal_path == "controller"
    told = located_at(Location("actuator", "it depends on the command"), "torque", "position")
    assert (told.signal_path, told.region) == ("plant", "it depends on the position")


def test_dead_zone_without_a_name_is_placed_in_the_actuator() -> None:
    with hidden({"actuator_dead_zone.width": 0.15}) as case:
        without = unnamed(case)
    assert without.signal_path == "actuator"
    assert "command" in without.region


def trajectory(seed: int) -> States:
    """A random smooth motion of 4 s at 1 kHz."""
    rng = np.random.default_rng(seed)
    time = np.arange(4000, dtype=np.float64) * 1e-3
    position = np.zeros_like(time)
    for frequency in (0.4, 0.9, 1.7, 2.6):
        phase = rng.uniform(0.0, 2.0 * np.pi)
        position += rng.uniform(0.5, 1.0) * np.sin(2.0 * np.pi * frequency * time + phase)
    velocity = np.gradient(position, time)
    command = 0.01 * np.gradient(velocity, time) + rng.uniform(0.1, 0.2) * velocity + position
    return States(time, position, velocity, command, command, rest=0.05)


@given(
    seed=st.integers(0, 10_000),
    state=st.sampled_from(["position", "velocity", "command"]),
    size=st.floats(1e-6, 1e6),
)
def test_state_that_makes_the_signal_explains_it_best(seed: int, state: str, size: float) -> None:
    states = trajectory(seed)
    x = getattr(states, state)
    rng = np.random.default_rng(seed)
    latent = size * (np.abs(x / np.std(x)) + 0.1 * rng.standard_normal(x.size))
    ranked = rank_states([latent], [states], observed=False)
    best = "speed" if state == "velocity" else state
    assert ranked[0].state in {best, state}
    assert ranked[0].share > 0.6


def test_sign_of_the_velocity_explains_plain_friction() -> None:
    states = trajectory(1)
    ranked = rank_states([states.direction], [states], observed=False)
    assert ranked[0].state == "direction"
    assert ranked[0].share == pytest.approx(1.0)


def test_constant_signal_follows_no_state() -> None:
    states = trajectory(1)
    assert rank_states([np.full(states.time.size, 2.0)], [states], observed=False) == []


def test_strongest_stretches_are_those_with_most_weight() -> None:
    grid = np.arange(1000, dtype=np.float64) * 1e-3
    mask = np.zeros(1000, dtype=np.bool_)
    weight = np.zeros(1000)
    for first, height in ((100, 1.0), (300, 5.0), (500, 3.0), (700, 4.0)):
        mask[first : first + 50] = True
        weight[first : first + 50] = height
    found = strongest([grid], [mask], [weight], 12)
    assert [s.start for s in found] == pytest.approx([0.3, 0.7, 0.5])
    assert all(s.end - s.start == pytest.approx(0.049) for s in found)


def test_long_stretch_is_cut_to_where_its_weight_lies() -> None:
    grid = np.arange(1000, dtype=np.float64) * 1e-3
    weight = np.exp(-(((grid - 0.6) / 0.05) ** 2))
    (only,) = strongest([grid], [np.ones(1000, dtype=np.bool_)], [weight], 12)
    assert 0.5 < only.start < 0.6 < only.end < 0.7


def test_stretch_of_one_row_is_long_enough_to_be_seen() -> None:
    grid = np.arange(1000, dtype=np.float64) * 1e-3
    (only,) = strongest([grid], [grid == 0.5], [np.ones(1000)], 12)
    assert only.end - only.start == pytest.approx(0.02)


def test_stretches_that_overlap_become_one_window() -> None:
    stretches = [Stretch(1, 0.4, 0.6, 1.0), Stretch(0, 0.1, 0.2, 9.0), Stretch(1, 0.5, 0.8, 2.0)]
    assert time_windows(stretches, ["a.csv", "b.csv"]) == (
        ("a.csv", 0.1, 0.2),
        ("b.csv", 0.4, 0.8),
    )


def test_recording_that_stands_still_has_no_moving_part() -> None:
    grid = np.arange(100, dtype=np.float64) * 1e-2
    (only,) = moving_parts([grid, grid], [np.zeros(100, dtype=np.bool_), grid > 0.5])
    assert only.record == 1
    assert only.end == pytest.approx(0.99)
