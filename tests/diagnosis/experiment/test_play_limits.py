"""What is played keeps every limit, sample by sample, whatever the limits are."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gmfbo import FmuTwin
from gmfbo.diagnosis.experiment.play_limits import PlayLimits, largest_rates
from gmfbo.diagnosis.experiment.play_patterns import play_patterns
from gmfbo.diagnosis.experiment.played_input import effort_for, imposed_velocity, played_input
from gmfbo.diagnosis.experiment.reference_menu import PARTS
from gmfbo.diagnosis.experiment.safe_player import SafePlayer
from gmfbo.diagnosis.runs.simulated import Point
from gmfbo.errors import InputError
from gmfbo.recordings.recording import read_recording
from gmfbo.recordings.writing.writer import write_recording
from gmfbo.sources.fmu_file.models import models_folder

ALL: Mapping[str, Any] = {
    "position": [-0.5, 0.5],
    "velocity": 4.0,
    "acceleration": 60.0,
    "jerk": 3000.0,
    "torque": 1.5,
    "duration": 6.0,
}
ROUNDING = 1.0 + 1e-6


def limits_of(**changed: object) -> PlayLimits:
    return PlayLimits.from_mapping({**ALL, **changed}, "limits.toml")


@st.composite
def any_limits(draw: st.DrawFn) -> PlayLimits:
    low, high = draw(st.floats(-3.0, -0.01)), draw(st.floats(0.01, 3.0))
    velocity = draw(st.floats(0.05, 20.0))
    acceleration = velocity * draw(st.floats(1.0, 60.0))
    jerk = draw(st.just(np.inf) | st.floats(2.0, 200.0).map(lambda f: f * acceleration))
    return PlayLimits(low, high, velocity, acceleration, draw(st.floats(4.0, 20.0)), jerk)


@given(any_limits())
@settings(max_examples=60, deadline=None)
def test_every_pattern_keeps_all_limits_and_rests_at_both_ends(limits: PlayLimits) -> None:
    spacing = 2e-3
    for entry in play_patterns(limits, 0.0, spacing):
        values = entry.values
        assert (values.size - 1) * spacing <= limits.duration / PARTS
        assert limits.low <= values.min() < values.max() <= limits.high
        for name, largest in largest_rates(values, spacing).items():
            assert largest <= limits.rate(name) * ROUNDING, name
        for end in (values[:4], values[-4:]):
            assert np.ptp(end) <= 1e-9 * np.ptp(values)
        assert values[0] == pytest.approx(0.0, abs=1e-12)
        assert values[-1] == pytest.approx(0.0, abs=1e-9 * np.ptp(values))


@given(st.integers(0, 10_000))
def test_rates_of_a_parabola_are_its_own(seed: int) -> None:
    a = np.random.default_rng(seed).uniform(0.1, 9.0)
    time = np.arange(100, dtype=np.float64) * 1e-2
    rates = largest_rates(0.5 * a * time**2, 1e-2)
    assert rates["acceleration"] == pytest.approx(a, rel=1e-6)
    assert rates["velocity"] == pytest.approx(a * (time[-1] - 0.5e-2), rel=1e-6)
    assert rates["jerk"] == pytest.approx(0.0, abs=1e-6)


def test_motions_one_after_the_other_keep_the_limits_of_each(tmp_path: Path) -> None:
    """The file itself is differenced: as it is read back, over the seam too."""
    limits = limits_of()
    with FmuTwin(models_folder() / "servo_axis.toml") as twin:
        played = played_input(twin)
        with SafePlayer(twin, played, limits, 2) as player:
            first, *_, last = play_patterns(limits, 0.0, twin.step)
            column = np.concatenate([first.values, last.values])
            write_recording(player.reference(column), tmp_path / "next.csv")
    text = (tmp_path / "next.csv").read_text()
    assert text.startswith("# gmfbo = ")
    assert "time [s],reference [rad]" in text
    read = read_recording(tmp_path / "next.csv")
    assert read.time[-1] <= limits.duration
    for name, largest in largest_rates(read.signal("reference"), 1e-3).items():
        assert largest <= limits.rate(name) * ROUNDING


def test_what_asks_for_too_much_torque_is_shrunk_until_it_does_not() -> None:
    with FmuTwin(models_folder() / "servo_axis.toml") as twin:
        loose, tight = limits_of(torque=100.0), limits_of(torque=0.1)
        (entry, *_) = play_patterns(loose, 0.0, twin.step)
        with SafePlayer(twin, played_input(twin), loose, 2) as player:
            *_, free, whole = player.shrunk(entry.values)
        with SafePlayer(twin, played_input(twin), tight, 2) as player:
            motion, column, peaks, share = player.shrunk(entry.values)
    assert whole == 1.0
    assert free.torque is not None
    assert peaks.torque is not None
    assert free.torque > 0.1 >= peaks.torque > 0.08
    assert share < 1.0
    assert column is motion
    assert motion == pytest.approx(share * entry.values)
    assert peaks.torque_unit == "N.m"


def test_the_limit_of_torque_holds_under_physics_that_was_found_too() -> None:
    friction = Point({}, {"coulomb_friction.level": 0.3, "coulomb_friction.deflection": 1e-5})
    limits = limits_of(torque=0.5)
    with FmuTwin(models_folder() / "servo_axis.toml") as twin:
        (entry, *_) = play_patterns(limits, 0.0, twin.step)
        with SafePlayer(twin, played_input(twin), limits, 2, [Point(), friction]) as player:
            *_, peaks, share = player.shrunk(entry.values)
        with SafePlayer(twin, played_input(twin), limits, 2) as player:
            *_, whole = player.shrunk(entry.values)
    assert peaks.torque is not None
    assert peaks.torque <= 0.5
    assert share < whole


def test_where_next_to_nothing_could_be_played_the_message_says_what_stands_in_the_way() -> None:
    limits = limits_of(torque=0.2)
    heavy = Point({}, {"constant_torque_offset.level": 0.5})
    with FmuTwin(models_folder() / "servo_axis.toml") as twin:
        (entry, *_) = play_patterns(limits, 0.0, twin.step)
        with (
            SafePlayer(twin, played_input(twin), limits, 2, [heavy]) as player,
            pytest.raises(InputError, match=r"asks for 0\.[56]\d* N\.m \(allowed 0\.2\)"),
        ):
            player.shrunk(entry.values)


@pytest.mark.parametrize(
    ("model", "name", "kind"),
    [
        ("servo_axis", "reference", "position"),
        ("emps", "reference", "position"),
        ("motor_bench", "current", "effort"),
        ("damper", "velocity", "velocity"),
    ],
)
def test_the_input_that_moves_the_axis_is_found(model: str, name: str, kind: str) -> None:
    with FmuTwin(models_folder() / f"{model}.toml") as twin:
        played = played_input(twin)
    assert (played.name, played.kind) == (name, kind)


@pytest.mark.parametrize("model", ["motor_bench", "damper"])
def test_a_plant_without_a_controller_stays_within_its_limits_in_simulation(model: str) -> None:
    limits = limits_of(position=[-0.2, 0.3], velocity=1.0, acceleration=20.0, torque=400.0)
    with (
        FmuTwin(models_folder() / f"{model}.toml") as twin,
        SafePlayer(twin, played_input(twin), limits, 2) as player,
    ):
        for entry in play_patterns(limits, player.start, twin.step):
            _, column, _, _ = player.shrunk(entry.values)
            run = twin.run({}, player.reference(column))
            assert np.ptp(column) > 0.0
            if "position" in run.signals:
                moved = run.signal("position")
                assert -0.2 <= moved.min() < moved.max() <= 0.3
                assert largest_rates(moved, twin.step)["velocity"] <= limits.velocity * ROUNDING


def test_the_effort_of_a_linear_plant_follows_a_motion_exactly() -> None:
    """Closed form: J p'' + c p' moves J q'' + c q' = u along p."""
    spacing, inertia, viscous = 1e-3, 0.02, 0.05
    time = np.arange(2000) * spacing
    motion = 0.3 * np.sin(np.pi * time / time[-1]) ** 4

    def moved(effort: np.ndarray[Any, np.dtype[np.float64]]) -> Any:
        position, velocity = np.zeros(effort.size), 0.0
        for k in range(1, effort.size):
            velocity += spacing * (effort[k - 1] - viscous * velocity) / inertia
            position[k] = position[k - 1] + spacing * velocity
        return position

    effort = effort_for(motion, spacing, moved, 0.1)
    assert moved(effort) == pytest.approx(motion, abs=2e-3 * np.ptp(motion))


def test_an_imposed_velocity_adds_up_to_the_motion() -> None:
    motion = np.cumsum(np.sin(np.arange(50) * 0.1)) * 1e-3
    velocity = imposed_velocity(motion, 1e-3)
    assert motion[0] + np.cumsum(velocity[:-1]) * 1e-3 == pytest.approx(motion[1:])


def test_a_plant_that_nothing_moves_is_refused() -> None:
    motion = np.sin(np.linspace(0.0, np.pi, 100)) ** 2
    with pytest.raises(InputError, match="expected an input that moves the axis"):
        effort_for(motion, 1e-3, lambda effort: np.zeros(effort.size), 1.0)


def test_too_short_a_time_is_refused() -> None:
    with pytest.raises(InputError, match="allow a longer duration"):
        play_patterns(limits_of(duration=0.05), 0.0, 1e-3)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"position": [0.5, -0.5]}, r"position = \[low, high\].*got \[0.5, -0.5\]"),
        ({"position": 0.5}, r"position = \[low, high\]"),
        ({"velocity": -1.0}, "velocity to be a number above zero, got -1.0"),
        ({"velocity": True}, "velocity to be a number above zero"),
        ({"jerk": float("inf")}, "jerk to be a number above zero, got inf"),
        ({"duration": "long"}, "duration to be a number above zero, got 'long'"),
        ({"accelleration": 1.0}, "no limit 'accelleration'; did you mean 'acceleration'"),
    ],
)
def test_a_limit_that_is_none_is_refused(changed: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        limits_of(**changed)


def test_limits_that_may_be_left_out_are_infinite_and_others_are_asked_for(tmp_path: Path) -> None:
    content = {name: value for name, value in ALL.items() if name not in ("jerk", "torque")}
    found = PlayLimits.from_mapping(content, "limits.toml")
    assert (found.jerk, found.torque) == (np.inf, np.inf)
    with pytest.raises(InputError, match="'velocity' is missing; add it"):
        PlayLimits.from_mapping({"position": [0.0, 1.0]}, "limits.toml")
    with pytest.raises(InputError, match="no limits file at"):
        PlayLimits.read(tmp_path / "limits.toml")
    (tmp_path / "limits.toml").write_text("position = [")
    with pytest.raises(InputError, match="not valid TOML"):
        PlayLimits.read(tmp_path / "limits.toml")
