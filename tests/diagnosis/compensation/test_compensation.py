"""A compensation cancels its effect: by the law, in the loop, and in C as in the table."""

from __future__ import annotations

import ctypes
import os
import subprocess
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from fmu_build.compile import find_compiler
from fmu_build.platforms import this_platform
from gmfbo import FmuTwin, Recording
from gmfbo.diagnosis.compensation.compensation import compensation_of
from gmfbo.diagnosis.compensation.laws import ADVICE
from gmfbo.diagnosis.compensation.structured_text import structured_text
from gmfbo.diagnosis.compensation.table import Compensation, CompensationTable
from gmfbo.diagnosis.compensation.text import c_text, csv_text
from gmfbo.diagnosis.result.whereabouts import Shape
from gmfbo.errors import InputError
from gmfbo.physics import CATALOGUE, States
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.twin.augmented_twin import AugmentedTwin
from tests.diagnosis.compensation.compensation_cases import VALUES, diagnosis_of
from tests.diagnosis.compensation.structured_text_reading import NotStructuredText, blocks

Column = NDArray[np.float64]
SERVO = models_folder() / "servo_axis.toml"


def made(*names: str) -> Compensation:
    return compensation_of(diagnosis_of({name: VALUES[name] for name in names}), "found")


def sweep(rows: int = 4001) -> dict[str, Column]:
    """States over all that the tables cover, the velocity never at rest."""
    phase = np.linspace(0.0, 2.0 * np.pi, rows)
    velocity = 3.0 * np.cos(3.0 * phase + 0.3)
    velocity = np.where(np.abs(velocity) < 0.1, 0.1, velocity)
    return {
        "position": 0.49 * np.sin(phase),
        "velocity": velocity,
        "acceleration": 100.0 * np.sin(2.0 * phase),
        "command": 1.9 * np.sin(5.0 * phase),
        "current": 1.8 * np.cos(4.0 * phase),
        "load": 1.8 * np.cos(4.0 * phase),
    }


def test_each_effect_has_either_a_table_or_an_advice() -> None:
    assert set(VALUES) | set(ADVICE) == set(CATALOGUE)
    assert not set(VALUES) & set(ADVICE)


MEMORY = {"presliding_friction", "hysteresis", "backlash", "load_inertia"}
BY_COMMAND = {"actuator_dead_zone", "actuator_gain_loss", "magnetic_saturation"}


@pytest.mark.parametrize("name", sorted(set(VALUES) - MEMORY - BY_COMMAND))
def test_a_table_is_minus_the_law_of_the_catalogue(name: str) -> None:
    at = sweep()
    states = States(
        time=np.arange(at["position"].size, dtype=np.float64) * 1e-3,
        position=at["position"],
        velocity=at["velocity"],
        command=at["command"],
        current=at["current"],
        rest=0.04,
        load_torque=at["load"],
    )
    signal = CATALOGUE[name].signal
    assert signal is not None
    law = signal(states, VALUES[name])
    left = law + made(name).value("torque", at)
    # Straight lines between the nodes: 256 a cycle, 40 over the speeds of each direction.
    assert np.abs(left).max() < 1.5e-2 * np.abs(law).max()


@pytest.mark.parametrize("name", sorted(BY_COMMAND))
def test_a_corrected_command_comes_out_of_the_actuator_as_it_was_meant(name: str) -> None:
    meant = np.concatenate([np.linspace(-1.9, -0.2, 200), np.linspace(0.2, 1.9, 200)])
    told = meant + made(name).value("command", {"command": meant})
    rest = np.zeros(told.size)
    signal = CATALOGUE[name].signal
    assert signal is not None
    states = States(rest + np.arange(told.size), rest, rest, told, rest)
    assert told + signal(states, VALUES[name]) == pytest.approx(meant, abs=2e-3)


def test_sliding_laws_with_memory_are_cancelled_once_they_slide() -> None:
    way = np.linspace(0.0, 0.5, 500)
    rest = np.zeros(way.size)
    for name in ("presliding_friction", "hysteresis"):
        signal = CATALOGUE[name].signal
        assert signal is not None
        law = signal(States(rest + np.arange(500), way, rest + 1.0, rest, rest), VALUES[name])
        left = law + made(name).value("torque", {"velocity": rest + 1.0})
        assert abs(left[-1]) < 2e-3
        assert "before it slides" in csv_text(made(name))


def test_backlash_moves_the_reference_by_half_the_gap_in_the_direction_of_motion() -> None:
    found = made("backlash")
    assert found.targets == ("reference",)
    moved = found.value("reference", {"velocity": np.array([-1.0, 0.0, 1.0])})
    assert moved == pytest.approx([-0.002, 0.0, 0.002])


def test_an_inertia_is_fed_forward_by_the_acceleration() -> None:
    at = {"acceleration": np.array([-50.0, 0.0, 50.0])}
    assert made("load_inertia").value("torque", at) == pytest.approx([-0.2, 0.0, 0.2])


def test_effects_add_up() -> None:
    at = sweep()
    both = made("coulomb_friction", "cogging_torque").value("torque", at)
    one, other = made("coulomb_friction"), made("cogging_torque")
    assert both == pytest.approx(one.value("torque", at) + other.value("torque", at))


@given(st.floats(-100.0, 100.0, exclude_min=True))
def test_friction_is_odd_and_never_more_than_its_level(velocity: float) -> None:
    found = made("coulomb_friction")
    plus, minus = (
        found.value("torque", {"velocity": np.array([v])})[0] for v in (velocity, -velocity)
    )
    assert plus == pytest.approx(-minus)
    assert abs(plus) <= 0.2
    assert plus * velocity >= 0.0


def test_the_sign_is_smoothed_within_the_velocity_that_is_asked_for() -> None:
    diagnosis = diagnosis_of({"coulomb_friction": {"level": 0.2}})
    found = compensation_of(diagnosis, "found", 0.5)
    at = {"velocity": np.array([0.25, 0.5, 1.0])}
    assert found.value("torque", at) == pytest.approx([0.1, 0.2, 0.2])


# ---- in the loop --------------------------------------------------------------------------------

LOOP = {
    "coulomb_friction": 20.0,
    "stribeck_friction": 4.0,
    "cogging_torque": 50.0,
    "gravity_torque": 300.0,
    "elastic_return": 300.0,
    "constant_torque_offset": 300.0,
}
"""By what factor at least the axis comes nearer to its nominal twin."""


def measured_factor(name: str) -> float:
    """By what an axis comes nearer: velocity of the reference, position as a drive measures it."""
    time = np.arange(3000, dtype=np.float64) * 1e-3
    reference = 0.4 * np.sin(2.0 * np.pi * 0.5 * time) * np.minimum(1.0, time / 0.3) ** 2
    wave = Recording(time=time, signals={"reference": reference})
    physics = {f"{name}.{key}": value for key, value in VALUES[name].items()}
    with AugmentedTwin(FmuTwin(SERVO), substeps=10, isolated=False) as axis:
        plan = axis.plan(wave, {})
        nominal = axis.run(plan, {})
        at = {"position": nominal.held["position"], "velocity": np.gradient(reference, time)}
        added = {"torque": made(name).value("torque", at)}
        without = axis.run(plan, {}, physics)
        with_it = axis.run(plan, {}, physics, excitation=added)

    def apart(run: Column) -> float:
        return float(np.sqrt(np.mean((run - nominal.held["position"]) ** 2)))

    # A constant is cancelled to the last bit.
    return apart(without.held["position"]) / max(apart(with_it.held["position"]), 1e-12)


@pytest.mark.parametrize("name", sorted(LOOP))
def test_an_axis_with_its_compensation_moves_as_its_nominal_twin(name: str) -> None:
    assert measured_factor(name) > LOOP[name]


def test_a_compensation_with_its_sign_turned_makes_it_worse() -> None:
    """Negative control: the factor above would see a wrong sign."""
    turned = {"constant_torque_offset": {"level": 0.15}}
    time = np.arange(1500, dtype=np.float64) * 1e-3
    wave = Recording(time=time, signals={"reference": 0.2 * np.sin(6.0 * time)})
    wrong = compensation_of(diagnosis_of(turned), "found")
    with AugmentedTwin(FmuTwin(SERVO), substeps=10, isolated=False) as axis:
        plan = axis.plan(wave, {})
        nominal = axis.run(plan, {}).held["position"]
        physics = {"constant_torque_offset.level": -0.15}
        without = axis.run(plan, {}, physics).held["position"] - nominal
        added = {"torque": wrong.value("torque", {"velocity": np.zeros(time.size)})}
        with_it = axis.run(plan, {}, physics, excitation=added).held["position"] - nominal
    assert np.std(with_it) > 1.5 * np.std(without)


# ---- text ---------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    """All torque effects at once, compiled as strict C99 with every warning an error."""
    folder = tmp_path_factory.mktemp("compensation")
    names = [n for n in VALUES if n not in BY_COMMAND]
    (folder / "all.c").write_text(c_text(made(*names, *sorted(BY_COMMAND))), encoding="utf-8")
    cache = Path(os.environ.get("ZIG_GLOBAL_CACHE_DIR", folder / "zig"))
    compiler = find_compiler("zig", cache, [this_platform()])
    flags = "-std=c99 -O2 -Wall -Wextra -Wpedantic -Wmissing-braces -Werror -fPIC -shared"
    contract = "-ffp-contract=off"
    done = subprocess.run(
        [*compiler.command, *flags.split(), contract, "-o", "all.so", "all.c"],
        cwd=folder,
        env={
            **os.environ,
            "ZIG_GLOBAL_CACHE_DIR": str(cache),
            "ZIG_LOCAL_CACHE_DIR": str(folder / ".zig-cache"),
        },
        capture_output=True,
        text=True,
    )
    assert (done.returncode, done.stderr) == (0, "")
    return ctypes.CDLL(str(folder / "all.so"))


@pytest.mark.parametrize("target", ["torque", "command", "reference"])
def test_the_c_function_equals_the_table(compiled: ctypes.CDLL, target: str) -> None:
    names = [n for n in VALUES if n not in BY_COMMAND]
    found = made(*names, *sorted(BY_COMMAND))
    states = list(dict.fromkeys(s for table in found.of(target) for s in table.states))
    function = getattr(compiled, f"{target}_compensation")
    function.argtypes, function.restype = [ctypes.c_double] * len(states), ctypes.c_double
    rng = np.random.default_rng(3)
    at = {state: rng.uniform(-9.0, 9.0, 500) for state in states}
    for table in found.of(target):
        at[table.over][: table.x.size] = table.x[:500]  # the nodes themselves
    expected = found.value(target, at)
    got = [function(*(float(at[state][k]) for state in states)) for k in range(500)]
    assert got == pytest.approx(expected, rel=1e-13, abs=1e-13)


def test_the_csv_holds_what_the_table_does() -> None:
    found = made("coulomb_friction", "cogging_torque")
    lines = csv_text(found).splitlines()
    head = [line for line in lines if line.startswith("# ")]
    names, *rows = [line.split(",") for line in lines if not line.startswith("#")]
    assert names == [
        "velocity of coulomb_friction [rad/s]",
        "coulomb_friction [N.m]",
        "position of cogging_torque [rad]",
        "cogging_torque [N.m]",
    ]
    for k, column in enumerate([c for table in found.tables for c in (table.x, table.y)]):
        assert [float(row[k]) for row in rows if row[k]] == column.tolist()
    story = "\n".join(head)
    assert "# diagnosis = found" in story
    assert "value to ADD so that the physics that the twin leaves out is cancelled" in story
    assert "torque at the motor shaft [N.m] = coulomb_friction(velocity) + cogging" in story


def test_what_cannot_be_compensated_is_listed_with_what_to_do() -> None:
    values = {"coulomb_friction": {"level": 0.2}, "transport_delay": {"delay": 1e-3}}
    found = compensation_of(diagnosis_of(values), "found")
    assert [entry.effect for entry in found.not_compensated] == ["transport_delay"]
    assert "# not compensated = transport delay: tune the gains" in csv_text(found)
    assert "not compensated = transport delay" in c_text(found)


@pytest.mark.parametrize("name", sorted(ADVICE))
def test_where_nothing_can_be_compensated_the_advice_is_the_message(name: str) -> None:
    with pytest.raises(InputError, match=name.replace("_", " ")):
        compensation_of(diagnosis_of({name: {}}), "found")


def test_a_diagnosis_that_names_nothing_has_nothing_to_compensate() -> None:
    with pytest.raises(InputError, match="it named nothing"):
        compensation_of(diagnosis_of({}), "found")


OF_VELOCITY = ("asymmetric_friction", "stribeck_friction", "viscous_friction", "quadratic_drag")


@pytest.mark.parametrize("name", ["coulomb_friction", *OF_VELOCITY])
def test_of_an_older_diagnosis_the_smoothing_tells_the_fastest_motion(name: str) -> None:
    """With it the same table: 0.04 rad/s is 1 % of the 4 rad/s of the newer diagnosis."""
    newer = diagnosis_of({name: VALUES[name]})
    older = replace(newer, predictions=None)
    with pytest.raises(InputError, match=r"give --smoothing VELOCITY.*or diagnose again"):
        compensation_of(older, "found")
    at = {"velocity": np.linspace(-5.0, 5.0, 101)}
    told, expected = compensation_of(older, "found", 0.04), compensation_of(newer, "found", 0.04)
    np.testing.assert_allclose(told.value("torque", at), expected.value("torque", at), rtol=1e-12)
    assert "how fast the axis moved" in " ".join(told.remarks)
    assert not expected.remarks


def test_what_needs_a_range_that_an_older_diagnosis_lacks_is_left_out_with_the_reason() -> None:
    names = ("coulomb_friction", "elastic_return", "torque_ripple")
    older = replace(diagnosis_of({name: VALUES[name] for name in names}), predictions=None)
    told = compensation_of(older, "found", 0.04)
    assert [table.effect for table in told.tables] == ["coulomb_friction"]
    assert [entry.effect for entry in told.not_compensated] == list(names[1:])
    assert all("diagnose again" in entry.advice for entry in told.not_compensated)


@pytest.mark.parametrize("smoothing", [0.0, -1.0, float("nan"), float("inf")])
def test_a_smoothing_that_is_no_velocity_is_refused(smoothing: float) -> None:
    with pytest.raises(InputError, match="expected a velocity above zero"):
        compensation_of(diagnosis_of({"coulomb_friction": {"level": 0.2}}), "found", smoothing)


def test_an_inferred_curve_is_cancelled_as_it_was_drawn() -> None:
    x, y = (-1.0, 0.0, 1.0), (0.3, 0.0, -0.3)
    shape = Shape("torque", "velocity", x, y, y, y, "rad/s", "N.m")
    diagnosis = replace(diagnosis_of({}), verdict="outside_library", shape=shape)
    found = compensation_of(diagnosis, "found")
    assert found.value("torque", {"velocity": np.array([0.5])}) == pytest.approx([0.15])
    against = "position, with the sign of the velocity"
    in_time = replace(diagnosis, shape=replace(shape, against=against))
    with pytest.raises(InputError, match="no function of one state"):
        compensation_of(in_time, "found")


def test_a_curve_is_not_cancelled_with_laws_that_were_fitted_without_it() -> None:
    x, y = (-1.0, 0.0, 1.0), (0.3, 0.0, -0.3)
    shape = Shape("torque", "velocity", x, y, y, y, "rad/s", "N.m")
    friction = diagnosis_of({"coulomb_friction": VALUES["coulomb_friction"]})
    beside = replace(friction, verdict="outside_library", shape=shape)
    found = compensation_of(beside, "found")
    assert [table.effect for table in found.tables] == ["coulomb_friction"]
    assert any("beside other values of the named laws" in remark for remark in found.remarks)


def test_two_lines_that_share_no_period_are_tabulated_over_what_was_recorded() -> None:
    values = {**VALUES["cogging_torque"], "sine_2": 0.02, "cosine_2": 0.0, "wavenumber_2": 31.7}
    found = compensation_of(diagnosis_of({"cogging_torque": values}), "found")
    (table,) = found.tables
    assert (table.period, table.x[0], table.x[-1]) == (0.0, -0.5, 0.5)


def test_a_compensation_of_a_weak_name_says_so_and_of_a_sure_one_does_not() -> None:
    sure = diagnosis_of({"coulomb_friction": VALUES["coulomb_friction"]})
    weak = replace(sure, effects=(replace(sure.effects[0], probability=0.62),))
    assert compensation_of(weak, "found").remarks == (
        "coulomb friction has a probability of 0.62 only: see on the axis whether this helps",
    )
    assert compensation_of(sure, "found").remarks == ()


# ---- Structured Text ----------------------------------------------------------------------------


def all_of_them() -> Compensation:
    return made(*(n for n in VALUES if n not in BY_COMMAND), *sorted(BY_COMMAND))


def points(tables: Sequence[CompensationTable], states: Sequence[str], rows: int) -> Column:
    """States, shape (rows, states): far and near, at rest, and the nodes themselves."""
    rng = np.random.default_rng(7)
    at = rng.uniform(-9.0, 9.0, (rows, len(states)))
    at[::7] *= 1e3  # many periods, and beyond the ends
    at[::11] *= 1e-4  # within the smoothed sign
    at[::101] = 0.0
    for table in tables:
        where = rng.choice(rows, min(table.x.size, rows // 10), replace=False)
        at[where, states.index(table.over)] = rng.choice(table.x, where.size)
    return at


@pytest.mark.parametrize("target", ["torque", "command", "reference"])
def test_structured_text_computes_what_the_c_function_does(
    compiled: ctypes.CDLL, target: str
) -> None:
    """Read by a grammar of its own; equal to the last bit, whichever way a controller rounds."""
    found = all_of_them()
    block = blocks(structured_text(found))[f"{target}_compensation"]
    rounds, cuts = block.function(round), block.function(int)
    in_c = getattr(compiled, f"{target}_compensation")
    in_c.argtypes, in_c.restype = [ctypes.c_double] * len(block.inputs), ctypes.c_double
    at = points(found.of(target), block.inputs, 10_000)
    expected = [in_c(*row) for row in at.tolist()]
    assert [rounds(*row) for row in at.tolist()] == expected
    assert [cuts(*row) for row in at[:2000].tolist()] == expected[:2000]
    assert len(set(expected)) > 100, "the points tell one value from another"


def test_control_a_changed_sign_or_digit_of_structured_text_is_noticed() -> None:
    text = structured_text(made("coulomb_friction", "cogging_torque"))
    right = blocks(text)["torque_compensation"].function()
    at = {"velocity": 2.0, "position": 0.3}
    for old, new in ((" + (y_2", " - (y_2"), ("0.2]", "0.2000000001]"), ("whole - 1", "whole - 2")):
        assert old in text
        changed = blocks(text.replace(old, new))["torque_compensation"].function(round)
        values = [changed(**{**at, "position": p}) for p in (0.3, -0.31)]
        assert values != [right(**{**at, "position": p}) for p in (0.3, -0.31)], new


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("total := 0.0;", "total := 0;", "expected LREAL, got DINT"),
        ("DINT_TO_LREAL(whole)", "whole", "LREAL beside DINT"),
        ("END_WHILE;", "END_FOR;", "END_FOR"),
        ("    whole : DINT;\n", "", "whole cannot be assigned to"),
        ("LREAL_TO_DINT(turns)", "LREAL_TO_INT(turns)", "no function lreal_to_int"),
        ("    low, high, middle : DINT;", "    low, at, middle : DINT;", "AT"),
    ],
)
def test_control_text_that_a_strict_compiler_refuses_is_refused(
    old: str, new: str, said: str
) -> None:
    text = structured_text(made("cogging_torque"))
    assert old in text
    with pytest.raises(NotStructuredText, match=said):
        blocks(text.replace(old, new, 1))


def test_numbers_of_structured_text_have_a_point_before_their_exponent() -> None:
    small = diagnosis_of({"constant_torque_offset": {"level": 2.5e-20}})
    large = diagnosis_of({"constant_torque_offset": {"level": -4e22}})
    for diagnosis, value in ((small, -2.5e-20), (large, 4e22)):
        text = structured_text(compensation_of(diagnosis, "found"))
        assert blocks(text)["torque_compensation"].function()(1.0) == value
    assert "4.0E+22" in text


def test_structured_text_tells_its_story_and_no_text_ends_its_comment() -> None:
    found = replace(made("coulomb_friction"), diagnosis="a *) b (* c")
    text = structured_text(found)
    assert "diagnosis = a * ) b ( * c" in text
    assert "value to ADD so that the physics that the twin leaves out is cancelled" in text
    assert [*blocks(text)] == ["torque_compensation"]
