"""Faults planted in one of two recordings are found there; sound recordings raise no finding."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo import FmuTwin, check
from gmfbo.diagnosis import Check
from gmfbo.diagnosis.checking.check import _free_runs
from gmfbo.diagnosis.checking.result import Finding
from gmfbo.diagnosis.checking.text import check_lines
from gmfbo.recordings.recording import Recording
from gmfbo.sources.fmu_file.models import models_folder
from tests.diagnosis.servo_recordings import rewritten
from tests.diagnosis.short_recordings import BENCH, SERVO, Axis, climb, multisine, open_small

Array = NDArray[np.float64]
Fault = Callable[[Recording], Recording]

FRICTION = {"coulomb_friction.level": 0.25, "coulomb_friction.deflection": 1e-6}


@pytest.fixture(scope="module")
def sound() -> list[Recording]:
    return SERVO.recordings({})


@pytest.fixture(scope="module")
def quick(tmp_path_factory: pytest.TempPathFactory) -> FmuTwin:
    """The servo with its sensor port alone: faults are seen by it, and few effects are tried."""
    text = SERVO.twin().path.read_text(encoding="utf-8")
    text = text.replace('fmu = "', f'fmu = "{models_folder().as_posix()}/')
    kept = [
        line for line in text.splitlines() if not line.startswith(("torque =", 'command = "tau'))
    ]
    path = tmp_path_factory.mktemp("twin") / "servo.toml"
    path.write_text("\n".join(kept), encoding="utf-8")
    return FmuTwin(path)


@pytest.fixture(scope="module")
def logged_new() -> list[Recording]:
    return SERVO.recordings({}, logged_new=("torque_command",), written_by="")


def kinds(seen: Check) -> list[tuple[str, str, str]]:
    return [(f.kind, f.recording, f.signal) for f in seen.findings]


def changed(signal: str, change: Callable[[Array], Array]) -> Fault:
    return lambda recording: recording.with_signals({signal: change(recording.signals[signal])})


def late(rows: int) -> Callable[[Array], Array]:
    return lambda column: np.concatenate([np.full(rows, column[0]), column[:-rows]])


def early(rows: int) -> Callable[[Array], Array]:
    return lambda column: np.concatenate([column[rows:], np.full(rows, column[-1])])


def repeated(column: Array) -> Array:
    spoiled = column.copy()
    for row in np.random.default_rng(1).choice(np.arange(100, 1300), 25, replace=False):
        spoiled[row] = spoiled[row - 1]
    return spoiled


def rounded(quantum: float) -> Callable[[Array], Array]:
    return lambda column: np.asarray(np.round(column / quantum) * quantum)


def without(rows: list[int], *, by_clock: bool) -> Fault:
    def lose(recording: Recording) -> Recording:
        kept = np.ones(len(recording), dtype=bool)
        kept[rows] = False
        time = recording.time[kept] if by_clock else recording.time[: kept.sum()]
        signals = {name: column[kept] for name, column in recording.signals.items()}
        return replace(recording, time=time, signals=signals)

    return lose


def all_blank(row: int) -> Fault:
    def lose(recording: Recording) -> Recording:
        rows = np.arange(len(recording)) == row
        signals = {n: np.where(rows, np.nan, column) for n, column in recording.signals.items()}
        return replace(recording, signals=signals)

    return lose


FAULTS: dict[str, tuple[Fault, str, str]] = {
    "command repeats": (
        changed("torque_command", repeated),
        "repeated_samples",
        "torque_command",
    ),
    "position repeats": (changed("position", repeated), "repeated_samples", "position"),
    "command at a quarter of the rate": (
        changed("torque_command", lambda u: np.repeat(u[::4], 4)),
        "latched_column",
        "torque_command",
    ),
    "rows missing by the clock": (without([300, 301, 700], by_clock=True), "lost_rows", ""),
    "rows missing in silence": (without([300, 301, 700], by_clock=False), "lost_rows", ""),
    "one cell without a value": (
        changed("position", lambda q: np.where(np.arange(q.size) == 500, np.nan, q)),
        "blank_samples",
        "position",
    ),
    "one row without a value": (all_blank(500), "lost_rows", ""),
    "coarse position": (changed("position", rounded(4e-3)), "coarse_column", "position"),
    "clipped command": (
        changed("torque_command", lambda u: np.clip(u, -0.6, 0.6)),
        "clipped_column",
        "torque_command",
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_is_the_only_finding(
    fault: str, sound: list[Recording], quick: FmuTwin
) -> None:
    plant, kind, signal = FAULTS[fault]
    seen = check(quick, [plant(sound[0]), sound[1]], jobs=1)
    assert kinds(seen) == [(kind, "rec0.csv", signal)]
    assert seen.findings[0].what
    assert seen.findings[0].cure


@pytest.mark.parametrize(
    ("signal", "change", "kind", "shift", "scale"),
    [
        ("torque_command", late(5), "shifted_column", 5e-3, None),
        ("torque_command", early(4), "shifted_column", -4e-3, None),
        ("position", late(2), "shifted_column", 2e-3, None),
        ("position", early(4), "shifted_column", -4e-3, None),
        ("torque_command", lambda u: 1.06 * u, "scaled_column", None, 1.06),
        ("position", lambda y: 1.03 * y, "scaled_column", None, 1.03),
    ],
)
def test_a_shifted_or_scaled_column_is_named_with_its_size(
    signal: str,
    change: Callable[[Array], Array],
    kind: str,
    shift: float | None,
    scale: float | None,
    sound: list[Recording],
    quick: FmuTwin,
) -> None:
    seen = check(quick, [changed(signal, change)(sound[0]), sound[1]], jobs=1)
    assert kinds(seen) == [(kind, "rec0.csv", signal)]
    found = seen.recordings["rec0.csv"].alignment[signal]
    assert found.basis == "controller"
    if shift is not None:
        assert found.shift == pytest.approx(shift, abs=0.2e-3)
    if scale is not None:
        assert found.scale == pytest.approx(scale, abs=3e-3)
    assert seen.logged == {"torque_command": "held"}  # the sound recording decides


def test_recordings_of_two_loggers_are_told_by_name(
    sound: list[Recording], logged_new: list[Recording], quick: FmuTwin
) -> None:
    """Each is compared by its own convention: none is late or early by a row."""
    other = replace(logged_new[1], written_by="")
    seen = check(quick, [replace(sound[0], written_by=""), other], jobs=1)
    assert kinds(seen) == [("mixed_conventions", "", "torque_command")]
    assert "in force in rec0.csv, but the command just computed in rec1.csv" in (
        seen.findings[0].what
    )
    assert seen.logged == {}
    for facts in seen.recordings.values():
        assert facts.parity < 3.0
        assert abs(facts.alignment["torque_command"].shift) < 0.1e-3


def test_without_its_controller_no_convention_of_a_command_is_told(
    logged_new: list[Recording], tmp_path: Path, quick: FmuTwin
) -> None:
    """What fits the twin's own run better is no evidence; what its file states is told."""
    text = quick.path.read_text(encoding="utf-8").replace('sensor = "encoder_offset"', "")
    for stated, told in (("unknown", {}), ("new", {"torque_command": "new"})):
        (path := tmp_path / f"{stated}.toml").write_text(text, encoding="utf-8")
        twin = FmuTwin(path)
        outputs = {**twin.file.outputs}
        outputs["torque_command"] = outputs["torque_command"].model_copy(update={"logged": stated})
        twin.file = twin.file.model_copy(update={"outputs": outputs})
        seen = check(twin, logged_new, jobs=1)
        assert seen.parity_why_not
        assert seen.logged == told


def test_an_offset_of_the_command_is_told_with_its_size(
    sound: list[Recording],
    quick: FmuTwin,
) -> None:
    seen = check(quick, [changed("torque_command", lambda u: u + 0.05)(sound[0]), sound[1]], jobs=1)
    assert [f.kind for f in seen.findings] == ["offset_column"]
    assert seen.recordings["rec0.csv"].alignment["torque_command"].offset == pytest.approx(
        0.05, rel=0.05
    )


@pytest.mark.parametrize(
    "hidden", [FRICTION, pytest.param({"actuator_saturation.limit": 0.8}, marks=pytest.mark.slow)]
)
def test_sound_recordings_raise_no_finding_whatever_the_twin_lacks(
    hidden: dict[str, float],
) -> None:
    seen = check(SERVO.twin(), SERVO.recordings(hidden), jobs=1)
    assert seen.findings == ()
    assert all(facts.parity < 3.0 for facts in seen.recordings.values())


@pytest.mark.parametrize(
    "hidden", [pytest.param({}, marks=pytest.mark.slow), {"coulomb_friction.level": 0.02}]
)
def test_sound_recordings_of_an_open_loop_plant_raise_no_finding(
    hidden: dict[str, float],
) -> None:
    seen = check(BENCH.twin(), BENCH.recordings(hidden), jobs=1)
    assert seen.findings == ()
    assert seen.parity_why_not == "the twin is an open-loop plant"


def test_an_open_loop_twin_is_compared_in_its_free_run() -> None:
    """An axis of twice the inertia: a loop that holds the twin on it would hide that."""
    heavy = replace(BENCH, truth={"inertia": 0.0104, "viscous": 0.012})
    ratios = []
    for axis in (BENCH, heavy):
        (seen,) = check(BENCH.twin(), axis.recordings({}), jobs=1).responses
        assert (seen.source, seen.signal) == ("current", "position")
        moves = np.array(seen.frequency) < 25.0  # above it there is noise alone
        ratios.append(float(np.median(np.divide(seen.gain, seen.twin_gain)[moves])))
    assert ratios == pytest.approx([1.0, 0.5], rel=0.15)


@pytest.mark.parametrize(("axis", "more"), [(BENCH, 1), (SERVO, 0)], ids=["open", "closed"])
def test_free_runs_of_an_open_loop_twin_count_as_simulations(axis: Axis, more: int) -> None:
    """A closed loop is compared in runs that were counted before."""
    case = open_small(axis.twin(), axis.recordings({})[:1])
    try:
        before = case.simulations.runs
        assert _free_runs(case) is not None
        assert case.simulations.runs == before + more
    finally:
        case.simulations.close()
        case.twin.close()


def test_a_logger_of_the_new_command_is_recognised(
    quick: FmuTwin, logged_new: list[Recording]
) -> None:
    seen = check(quick, logged_new, jobs=1)
    assert seen.logged == {"torque_command": "new"}
    assert seen.findings == ()


def test_a_twin_file_that_states_the_wrong_convention_is_corrected(
    quick: FmuTwin, logged_new: list[Recording]
) -> None:
    twin = FmuTwin(quick.path)
    outputs = {**twin.file.outputs}
    outputs["torque_command"] = outputs["torque_command"].model_copy(update={"logged": "held"})
    twin.file = twin.file.model_copy(update={"outputs": outputs})
    seen = check(twin, logged_new, jobs=1)
    assert kinds(seen) == [("logger_convention", "", "torque_command")]
    assert 'logged = "new"' in seen.findings[0].cure


@pytest.mark.parametrize(("gain", "stated"), [("kp", 42.0), ("kd", 0.6)])
def test_a_gain_that_the_file_states_wrongly_is_named_with_its_value(
    gain: str, stated: float, sound: list[Recording], quick: FmuTwin
) -> None:
    true = {"kp": 40.0, "kd": 0.8}
    recordings = [replace(r, parameters={**true, gain: stated}) for r in sound]
    seen = check(quick, recordings, jobs=1)
    assert {(f.kind, f.signal) for f in seen.findings} == {("controller_gain", gain)}
    told = re.search(r"was ([0-9.]+) times", seen.findings[0].what)
    assert told is not None
    assert float(told[1]) == pytest.approx(true[gain] / stated, rel=0.02)


def test_another_law_of_control_is_no_wrong_column(sound: list[Recording], quick: FmuTwin) -> None:
    def fed_forward(recording: Recording) -> Recording:
        rate = np.gradient(recording.signals["reference"], recording.time)
        command = recording.signals["torque_command"] + 0.3 * np.sign(rate)
        return recording.with_signals({"torque_command": command})

    seen = check(quick, [fed_forward(sound[0]), sound[1]], jobs=1)
    assert kinds(seen) == [("controller_parity", "rec0.csv", "torque_command")]


def test_a_command_that_is_computed_from_a_coarse_reading_misses_no_sample(
    sound: list[Recording], quick: FmuTwin
) -> None:
    """A command in proportion to an error of position that shows one count, or none, at rest."""
    noise = np.random.default_rng(6).standard_normal(sound[1].time.size)
    read = 1e-3 * np.round(sound[1].signals["position"] / 1e-3 + 0.8 * noise)
    command = 40.0 * (sound[1].signals["reference"] - read) + 1e-4 * np.cumsum(noise)
    columns = {"position": read, "torque_command": np.asarray(np.round(command, 4))}
    seen = check(quick, [sound[0], sound[1].with_signals(columns)], jobs=1)
    assert seen.recordings["rec1.csv"].columns["torque_command"].repeated == 0


def test_of_a_controller_that_computes_something_else_no_logger_is_told(
    sound: list[Recording], quick: FmuTwin
) -> None:
    """Its residual is that of another command, and as large whichever value the rows hold."""
    other = [
        r.with_signals({"torque_command": np.asarray(np.sin(2.0 * np.pi * 1.3 * r.time))})
        for r in sound
    ]
    seen = check(quick, other, jobs=1)
    assert {f.kind for f in seen.findings} == {"controller_parity"}
    assert seen.logged == {}


def test_recordings_without_a_reversal_say_so(quick: FmuTwin) -> None:
    seen = check(quick, SERVO.recordings({}, (climb,)), jobs=1)
    assert [f.kind for f in seen.findings] == ["no_reversal"]
    silent = {entry.name: entry.why for entry in seen.not_testable}
    assert silent["coulomb_friction"] == "the twin has no torque port"


def test_a_speed_that_is_nothing_but_rounding_is_printed_as_zero(
    sound: list[Recording], quick: FmuTwin
) -> None:
    seen = check(quick, sound[:1], jobs=1)
    facts = replace(seen.recordings["rec0.csv"], speed=(-1.6e-43, 21.0))
    (row,) = (
        line
        for line in check_lines(replace(seen, recordings={"rec0.csv": facts}))
        if line.startswith("rec0.csv ") and " ms" in line
    )
    assert " 0 to 21 " in row


def test_a_plant_without_controller_and_position_says_so(tmp_path: Path) -> None:
    """Only a speed was recorded: the twin's own position is no fact of the recording."""
    measured = {'position = "position"                       # [rad]\n': 'velocity = "velocity"\n'}
    twin = rewritten("motor_bench", tmp_path, measured)
    axis = replace(BENCH, noise={"velocity": 1e-2})
    seen = check(twin, axis.recordings({}, (multisine,), twin=twin), jobs=1)
    assert seen.parity_why_not == "the twin is an open-loop plant"
    (facts,) = seen.recordings.values()
    assert not facts.has_position
    (row,) = [line for line in check_lines(seen) if line.startswith("rec0.csv ")]
    assert row.split()[-6] == "-"


def test_a_recording_without_a_trusted_response_says_why(
    sound: list[Recording], quick: FmuTwin
) -> None:
    seen = check(quick, sound[:1], jobs=1)
    assert not any(line.startswith("up to -: ") for line in check_lines(seen))
    facts = replace(seen.recordings["rec0.csv"], bandwidth=float("nan"))
    told = check_lines(replace(seen, recordings={"rec0.csv": facts}))
    assert any(line.startswith("up to -: noise hides the response to reference") for line in told)
    assert not any("- Hz" in line for line in told)
    assert facts.has_position


def test_facts_of_a_recording_are_those_that_were_recorded(
    sound: list[Recording], quick: FmuTwin
) -> None:
    seen = check(quick, sound, jobs=1)
    assert seen.findings == ()
    assert all(found.parity < 3.0 for found in seen.recordings.values())
    facts = seen.recordings["rec0.csv"]
    position = sound[0].signals["position"]
    assert facts.position == (position.min(), position.max())
    assert facts.columns["torque_command"].limit == 10.0
    assert facts.columns["torque_command"].limit_from == "torque_limit"
    assert facts.columns["position"].noise == pytest.approx(3e-5, rel=0.2)
    assert facts.clock.step == pytest.approx(1e-3)


def test_no_parameter_is_fitted_and_the_users_twin_is_left_as_it_was() -> None:
    axis = Axis(truth={"inertia": 0.015, "viscous": 0.03})
    twin = FmuTwin(axis.twin().path)
    before = twin.file
    seen = check(twin, axis.recordings({}), jobs=1)
    assert twin.file is before
    assert seen.findings == ()
    told = {response.signal: response for response in seen.responses}
    # 50 % more inertia: the command is larger, although no column is wrong.
    assert told["torque_command"].apart > 0.2


def test_without_its_controller_no_column_is_told_as_late(
    sound: list[Recording], quick: FmuTwin
) -> None:
    """One file lacks the command: what friction holds up is not the position's clock."""
    rubbing = SERVO.recordings(FRICTION)
    signals = {n: c for n, c in rubbing[1].signals.items() if n != "torque_command"}
    for second, is_told in ((rubbing[1], True), (replace(rubbing[1], signals=signals), False)):
        seen = check(quick, [rubbing[0], second], jobs=1)
        (row,) = [line for line in check_lines(seen) if line.startswith("position ")]
        assert (row.split()[-2] != "-") == is_told


def test_two_faults_of_one_kind_do_not_hide_each_other(
    sound: list[Recording], quick: FmuTwin
) -> None:
    seen = check(quick, sound, jobs=1)
    by_clock = Finding("lost_rows", "rec0.csv", "", "3 rows are missing by the clock", "log anew")
    by_jump = Finding("lost_rows", "rec0.csv", "", "all signals jump at 0.3 s", "cut it there")
    again = Finding("lost_rows", "rec1.csv", "", "12 rows are missing by the clock", "log anew")
    found = replace(seen, findings=(by_clock, by_jump, again))
    said = "\n".join(check_lines(found))
    assert "rec0.csv and 1 more: 3 to 12 rows are missing by the clock" in said
    assert "rec0.csv: all signals jump at 0.3 s" in said
    each = "\n".join(check_lines(found, every=True))
    assert "rec0.csv: 3 rows are missing by the clock" in each
    assert "rec1.csv: 12 rows are missing by the clock" in each
