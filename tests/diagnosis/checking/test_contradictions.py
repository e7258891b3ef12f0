"""Wrong columns are refused in one line; the largest effects of the library are not."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo import FmuTwin, check, diagnose
from gmfbo.diagnosis.checking.consistent_recordings import consistent
from gmfbo.diagnosis.checking.contradicted_motion import judge_motions
from gmfbo.errors import RecordingError
from gmfbo.physics import CATALOGUE, Excitation
from gmfbo.recordings.recording import Recording
from gmfbo.sources.recorded.contradiction import refuse_contradictions
from gmfbo.sources.recorded.controlled_signal import reference_of
from gmfbo.sources.recorded.likeness import likeness
from gmfbo.sources.recorded.mistaken_unit import mistaken_unit
from tests.diagnosis.servo_recordings import rewritten
from tests.diagnosis.short_recordings import (
    QUIET_SERVO,
    SERVO,
    Axis,
    moves,
    multisine,
    open_small,
    triangle,
)

Array = NDArray[np.float64]
DEGREES = 180.0 / np.pi
DRIVE = Axis("drive_twin", truth={}, gains={}, noise={})


@pytest.fixture(scope="module")
def twin() -> FmuTwin:
    return SERVO.twin()


@pytest.fixture(scope="module")
def sound() -> list[Recording]:
    return SERVO.recordings({}, (multisine, moves, triangle))


@pytest.fixture(scope="module")
def little() -> Recording:
    """A small motion: the twin's command is limited, which degrees for rad would run into."""
    return QUIET_SERVO.recordings({}, [lambda t: 0.02 * multisine(t)])[0]


@pytest.fixture(scope="module")
def excitation(twin: FmuTwin, sound: list[Recording]) -> Excitation:
    case = open_small(twin, sound)
    case.simulations.close()
    return case.setting.excitation


def scaled(recording: Recording, **factors: float) -> Recording:
    changed = {name: factor * recording.signal(name) for name, factor in factors.items()}
    return recording.with_signals(changed)


WRONG: dict[str, tuple[Mapping[str, float], str]] = {
    "flipped position": ({"position": -1.0}, "position has the opposite sign"),
    "position in degrees": ({"position": DEGREES}, "as if it were in deg"),
    "position in turns": ({"position": 0.5 / np.pi}, "as if it were in rev"),
    "reference in degrees": ({"reference": DEGREES}, "reference is 5.+ as if it were in deg"),
    "flipped command": ({"torque_command": -1.0}, "torque_command has the opposite sign"),
    "command in mN.m": ({"torque_command": 1e3}, "torque_command is .* in mN.m"),
    "motion in degrees": (
        {"reference": DEGREES, "position": DEGREES},
        "only as if reference and position were in deg",
    ),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_a_wrong_column_is_refused_in_one_line(
    wrong: str, twin: FmuTwin, little: Recording
) -> None:
    factors, said = WRONG[wrong]
    with pytest.raises(RecordingError, match=f"^rec0.csv: .*{said}") as refused:
        consistent(twin, [scaled(little, **factors)], seed=0, jobs=1)
    assert "\n" not in str(refused.value)


def setpoint(recording: Recording) -> Recording:
    signals = {("setpoint" if n == "reference" else n): c for n, c in recording.signals.items()}
    return replace(recording, signals=signals)


@pytest.mark.parametrize("wrong", WRONG)
def test_the_reference_is_known_by_its_role_and_not_by_its_name(
    wrong: str, tmp_path: Path, little: Recording
) -> None:
    twin = rewritten("servo_axis", tmp_path, {'reference = "reference"': 'setpoint = "reference"'})
    factors, said = WRONG[wrong]
    consistent(twin, [setpoint(little)], seed=0, jobs=1)
    said = said.replace("reference", "setpoint")
    with pytest.raises(RecordingError, match=f"^rec0.csv: .*{said}"):
        consistent(twin, [setpoint(scaled(little, **factors))], seed=0, jobs=1)


OWN = {'reference = "reference"': 'setpoint = "reference"'}
ROLES: dict[str, tuple[str, Mapping[str, str], str]] = {
    "by name": ("servo_axis", {}, "reference"),
    "by role": ("servo_axis", OWN, "setpoint"),
    "a port beside it": (
        "servo_axis",
        {**OWN, "[outputs]": 'offset = "encoder_offset"\n[outputs]'},
        "setpoint",
    ),
    "two that could be it": (
        "servo_axis",
        {
            **OWN,
            "[outputs]": 'tilt = "encoder_offset"\n[outputs]',
            'sensor = "encoder_offset"': "#",
        },
        "",
    ),
    "no computed command": ("servo_axis", {**OWN, '\ncommand = "torque_command"': ""}, ""),
    "open loop": ("motor_bench", {}, ""),
}


@pytest.mark.parametrize("case", ROLES)
def test_an_input_is_the_reference_only_where_no_other_could_be(case: str, tmp_path: Path) -> None:
    model, changes, name = ROLES[case]
    assert reference_of(rewritten(model, tmp_path, changes)) == name


def stops(t: Array) -> Array:
    """Steps of 1 rad, at which the command meets its limit in rad as well."""
    return 0.5 * np.sign(np.sin(2.0 * np.pi * 0.9 * t))


@pytest.mark.parametrize(
    ("unit", "reference"), [("deg", stops), ("deg", multisine), ("mrad", multisine)]
)
def test_motion_in_one_wrong_unit_is_told_where_it_drives_the_twin_into_its_limit(
    unit: str, reference: Callable[[Array], Array], twin: FmuTwin
) -> None:
    """At its limit the twin follows nothing, and a push at it meets no controller."""
    factor = {"deg": DEGREES, "mrad": 1000.0}[unit]
    (moved,) = SERVO.recordings({}, [reference])
    with pytest.raises(RecordingError, match=f"^rec0.csv: .*reference and position were in {unit}"):
        consistent(twin, [scaled(moved, reference=factor, position=factor)], seed=0, jobs=1)


def test_without_a_sensor_port_the_unit_of_the_motion_is_a_note(
    tmp_path: Path, sound: list[Recording]
) -> None:
    """No controller can be asked; the axis may be another one."""
    deaf = rewritten("servo_axis", tmp_path, {'sensor = "encoder_offset"': "#"})
    wrong = scaled(sound[0], reference=DEGREES, position=DEGREES)
    (note,) = consistent(deaf, [wrong], seed=0, jobs=1).notes
    assert note.startswith("rec0.csv: reference and position seem to be in deg: read so, the twin")
    turned = scaled(sound[0], reference=0.5 / np.pi, position=0.5 / np.pi)
    assert consistent(deaf, [turned], seed=0, jobs=1).notes == ()  # an effect may do as much
    assert consistent(deaf, sound, seed=0, jobs=1).notes == ()


def test_a_command_that_another_unit_would_explain_is_the_controllers_to_judge(
    twin: FmuTwin,
) -> None:
    """Negative control: an inertia six times as large asks for the command of a turn for a rad."""
    heavy = Axis(truth={**SERVO.truth, "inertia": 2.0 * np.pi * 0.01}).recordings({}, [multisine])
    consistent(twin, heavy, seed=0, jobs=1)


def test_position_of_another_axis_is_refused(twin: FmuTwin, sound: list[Recording]) -> None:
    other = {"position": sound[1].signal("position")}
    with pytest.raises(RecordingError, match="position does not follow reference"):
        consistent(twin, [sound[0].with_signals(other)], seed=0, jobs=1)


def test_another_run_of_the_axis_is_refused(twin: FmuTwin, sound: list[Recording]) -> None:
    other = {name: sound[1].signal(name) for name in ("position", "torque_command")}
    with pytest.raises(RecordingError, match="position does not follow reference"):
        consistent(twin, [sound[0].with_signals(other)], seed=0, jobs=1)


@pytest.mark.parametrize("command", [check, diagnose])
def test_check_and_diagnose_build_nothing_on_a_contradiction(
    command: Callable[..., object], twin: FmuTwin, sound: list[Recording]
) -> None:
    with pytest.raises(RecordingError, match="opposite sign"):
        command(twin, [sound[0], scaled(sound[1], position=-1.0)], jobs=1)


def test_sound_recordings_pass_without_a_word(twin: FmuTwin, sound: list[Recording]) -> None:
    assert not refuse_contradictions(twin, sound)
    given = consistent(twin, sound, seed=0, jobs=1)
    assert (list(given.recordings), given.notes, given.missing) == (sound, (), ())


LARGEST = (
    "coulomb_friction",
    "load_dependent_friction",
    "viscous_friction",
    "elastic_return",
    "actuator_gain_loss",
    "actuator_saturation",
    "actuator_dead_zone",
    "magnetic_saturation",
    "transport_delay",
    "sensor_scale",
    "sensor_offset",
    "cogging_torque",
)


@pytest.mark.parametrize("effect", LARGEST)
def test_the_largest_of_an_effect_is_not_refused(
    effect: str, twin: FmuTwin, excitation: Excitation
) -> None:
    """Stalled axes, half the gain, limit cycles: what a diagnosis is asked about."""
    law = CATALOGUE[effect]
    largest = {f"{effect}.{p.name}": p.high(excitation) for p in law.parameters}
    refuse_contradictions(twin, SERVO.recordings(largest, (multisine, moves, triangle)))


@pytest.mark.parametrize("effect", ["load_dependent_friction", "actuator_gain_loss"])
def test_the_controller_clears_a_command_that_is_far_off(
    effect: str, twin: FmuTwin, excitation: Excitation
) -> None:
    """The command differs tenfold from the simulated one, as the plant asked for it."""
    largest = {f"{effect}.{p.name}": p.high(excitation) for p in CATALOGUE[effect].parameters}
    recordings = SERVO.recordings(largest, (multisine, triangle))
    assert refuse_contradictions(twin, recordings)
    consistent(twin, recordings, seed=0, jobs=1)


@pytest.mark.slow
@pytest.mark.parametrize("axis", [SERVO, DRIVE], ids=["servo", "drive"])
def test_no_effect_of_the_library_is_refused_at_its_largest(axis: Axis) -> None:
    own, references = axis.twin(), (multisine, moves, triangle)
    case = open_small(own, axis.recordings({}, references))
    case.simulations.close()
    for name in CATALOGUE:
        for share in (1.0, 0.5):
            physics = {
                f"{name}.{p.name}": share * p.high(case.setting.excitation)
                for p in CATALOGUE[name].parameters
            }
            recordings = axis.recordings(physics, references)
            doubts = refuse_contradictions(own, recordings)
            assert judge_motions(own, recordings, doubts, seed=0, jobs=1) == []


def test_a_range_that_explains_the_gain_speaks_for_the_axis(
    tmp_path: Path, sound: list[Recording]
) -> None:
    """An uncertain gain of the loop may make the axis stay far behind its reference."""
    weak = {"kp": 0.1, "kd": 0.8}
    recording = Axis(truth={**SERVO.truth, "viscous": 0.2}, gains=weak).recordings({}, [multisine])
    stated = Recording(
        time=recording[0].time,
        signals=recording[0].signals,
        name="rec0.csv",
        parameters={"kd": 0.8},
    )
    free = rewritten("servo_axis", tmp_path, {"[uncertain]": '[uncertain]\n"kp" = [0.05, 40.0]'})
    refuse_contradictions(free, [stated])


@pytest.mark.parametrize("size", [0.2, 3.5])
def test_a_single_step_tells_the_unit_and_the_sign(size: float, twin: FmuTwin) -> None:
    """The reference moves in one row: halves of the motion are those of what follows it."""
    (moved,) = SERVO.recordings({}, [lambda t: np.where(t > 0.1, size, 0.0)])
    refuse_contradictions(twin, [moved])
    for factor, said in (
        (DEGREES, "as if it were in deg"),
        (0.5 / np.pi, "as if it were in rev"),
        (-1.0, "has the opposite sign"),
    ):
        with pytest.raises(RecordingError, match=f"position .*{said}"):
            refuse_contradictions(twin, [scaled(moved, position=factor)])


@pytest.mark.parametrize(("factor", "unit"), [(DEGREES, "deg"), (0.5 / np.pi, "rev")])
def test_a_range_at_whose_end_the_loop_swings_explains_no_unit(
    factor: float, unit: str, twin: FmuTwin
) -> None:
    """At twice the inertia the twin moves otherwise, but not 57 times as far."""
    (moved,) = SERVO.recordings({}, [lambda t: 3.5 * (1.0 - np.exp(-t / 0.06))])
    refuse_contradictions(twin, [moved])
    with pytest.raises(RecordingError, match=f"position is .* as if it were in {unit}"):
        refuse_contradictions(twin, [scaled(moved, position=factor)])


def test_open_loop_plants_are_not_judged(tmp_path: Path) -> None:
    """Without a loop, physics decides how far an axis moves, and where to."""
    bench = Axis("motor_bench", "current", {}, {}, {})
    recordings = bench.recordings({}, [multisine])
    flipped = [scaled(r, position=-1.0) for r in recordings]
    assert not refuse_contradictions(bench.twin(), flipped)


@pytest.mark.parametrize(
    ("unit", "gain", "told"),
    [
        ("rad", DEGREES, "deg"),
        ("rad", 0.16, "rev"),
        ("rad", 1.0, None),
        ("rad", 0.5, None),
        ("rad", 2.0, None),
        ("rad", 20.0, None),
        ("rad/s", 9.55, "rpm"),
        ("m", 1000.0, "mm"),
        ("N.m", 1000.0, "mN.m"),
        ("N.m", DEGREES, None),
        ("", DEGREES, None),
    ],
)
def test_a_gain_counts_for_a_unit_only_where_it_is_near(
    unit: str, gain: float, told: str | None
) -> None:
    assert mistaken_unit(unit, gain) == told


def test_half_a_period_of_a_sine_is_no_flipped_sign() -> None:
    time = np.linspace(0.0, 8.0, 4000)
    sine = np.sin(2.0 * np.pi * time)
    seen = likeness(-sine, sine)
    assert seen is not None
    assert seen.correlation == pytest.approx(-1.0)
    assert seen.shifted > 0.9


def test_likeness_is_that_of_the_means_removed() -> None:
    rng = np.random.default_rng(0)
    one = rng.standard_normal(3000)
    seen = likeness(3.0 - 2.0 * one, one + 7.0)
    assert seen is not None
    assert seen.gain == pytest.approx(-2.0)
    assert seen.is_flipped
    assert likeness(one, np.full(3000, 0.1)) is None
    unrelated = likeness(rng.standard_normal(3000), one)
    assert unrelated is not None
    assert unrelated.is_unrelated
    assert not unrelated.is_flipped
