"""`gmfbo init`: from a vendor's FMU and a log to files that run, and to a first verdict."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Callable
from io import StringIO
from pathlib import Path

import numpy as np
import pytest

from gmfbo import FmuTwin, Recording, Study, models_folder
from gmfbo.cli import main
from tests.cli.twins.vendor_axis import (
    axis_runs,
    in_ms_and_degrees,
    vendor_fmu,
    write_csv,
    write_matlab,
    write_mdf4,
)


def run(*arguments: object) -> int:
    return main([str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def runs() -> list[Recording]:
    return axis_runs(runs=2, rows=1000)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, runs: list[Recording]) -> Path:
    made = tmp_path_factory.mktemp("bench")
    vendor_fmu(made / "AX7.fmu")
    for k, one in enumerate(runs):
        write_csv(made / f"run{k}.csv", in_ms_and_degrees(one))
    return made


@pytest.fixture
def bench(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Folder of a person with an FMU and two logs, in which commands run."""
    monkeypatch.chdir(folder)
    return folder


def test_two_files_that_run_at_once(
    bench: Path, runs: list[Recording], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("init", "AX7.fmu", "run0.csv", "run1.csv", "--out", tmp_path / "axis") == 0
    said = capsys.readouterr().out
    twin = tmp_path / "axis" / "twin.toml"
    with FmuTwin(twin) as source:
        recording = Recording.read("run0.csv", source)
        gains, file = source.gains, source.file
    for name in ("reference", "position", "torque_command"):
        np.testing.assert_allclose(recording.signal(name), runs[0].signal(name), atol=1e-7)
    np.testing.assert_allclose(recording.time, runs[0].time, atol=1e-12)
    assert {name: entry.variable for name, entry in file.outputs.items()} == {
        "position": "enc.phi",
        "torque_command": "ctl.tauCmd",
    }
    assert file.ports == {"torque": "dist.tau", "command": "dist.tauCmd", "sensor": "dist.enc"}
    assert file.states["position"] == "mot.phiTrue"
    assert file.roles == {"inertia": "mech.J"}
    assert [gain.name for gain in gains.gains] == ["ctl.Kp", "ctl.Kd"]
    # Errors are those of 'gmfbo simulate', which shares nothing with the guesses.
    assert run("simulate", twin, "--reference", "run0.csv", "--out", tmp_path / "s.csv") == 0
    simulated = re.findall(r"^(\w+) +([\d.]+) %$", capsys.readouterr().out, re.MULTILINE)
    row = next(line for line in said.splitlines() if re.match(r"run0\.csv .*%", line))
    for told, (_, precise) in zip(re.findall(r"([\d.]+) %", row), simulated, strict=True):
        assert float(told) == pytest.approx(float(precise), rel=0.05)
    study = Study.read(tmp_path / "axis" / "study.toml")
    assert study.file.reference.step == 0.4


def test_check_takes_what_it_wrote(
    bench: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("init", "AX7.fmu", "run1.csv", "--out", tmp_path) == 0
    assert run("check", tmp_path / "twin.toml", "run1.csv", "--jobs", 1) == 0
    said = capsys.readouterr().out
    assert "controller: computes what was recorded" in said
    assert re.search(r"^coulomb friction +[\d.]+ N m", said, re.MULTILINE)


def test_each_guess_is_marked_and_what_a_file_states_is_not(bench: Path, tmp_path: Path) -> None:
    assert run("init", "AX7.fmu", "run0.csv", "--out", tmp_path, "--set",
               "position=ActPos_deg [deg]") == 0  # fmt: skip
    lines = (tmp_path / "twin.toml").read_text().splitlines()
    marked = {line.split(" ")[0] for line in lines if "guess" in line}
    assert {"reference", "torque_command", "[gains]", "[uncertain]", "torque", "inertia"} <= marked
    columns = lines[lines.index(next(line for line in lines if line.startswith("[columns]"))) :]
    stated = [line for line in columns if line.startswith(("position =", "time ="))][:2]
    assert not [line for line in stated if "guess" in line]


def test_times_in_ms_and_angles_in_degrees_without_any_unit(
    bench: Path, runs: list[Recording], tmp_path: Path
) -> None:
    table = dict(
        zip(("t", "soll", "ist", "moment"), in_ms_and_degrees(runs[0]).values(), strict=True)
    )
    log = write_csv(tmp_path / "plain.csv", table)
    assert run("init", "AX7.fmu", log, "--out", tmp_path / "axis") == 0
    text = (tmp_path / "axis" / "twin.toml").read_text()
    assert 'time = { column = "t", unit = "ms" }  # guess: its rows are 1 apart' in text
    assert (
        'position = { column = "ist", unit = "deg" }  # guess: no unit stated, deg fits best'
        in text
    )
    with FmuTwin(tmp_path / "axis" / "twin.toml") as source:
        recording = Recording.read(log, source)
    np.testing.assert_allclose(recording.signal("position"), runs[0].signal("position"), atol=1e-7)


def test_control_seconds_and_radians_without_any_unit_stay_so(
    bench: Path, runs: list[Recording], tmp_path: Path
) -> None:
    names = {"soll": "reference", "ist": "position", "moment": "torque_command"}
    columns = {"t": runs[0].time, **{name: runs[0].signal(of) for name, of in names.items()}}
    log = write_csv(tmp_path / "plain.csv", columns)
    assert run("init", "AX7.fmu", log, "--out", tmp_path / "axis") == 0
    text = (tmp_path / "axis" / "twin.toml").read_text()
    assert 'position = "ist"  # guess: by the column\'s name' in text
    assert 'time = "t"  # guess: its name; in seconds' in text


@pytest.mark.parametrize(("ending", "write"), [("mat", write_matlab), ("mf4", write_mdf4)])
def test_matlab_and_mdf4_logs_in_degrees(
    bench: Path,
    runs: list[Recording],
    tmp_path: Path,
    ending: str,
    write: Callable[[Path, Recording], Path],
) -> None:
    log = write(tmp_path / f"run.{ending}", runs[0])
    assert run("init", "AX7.fmu", log, "--out", tmp_path / "axis") == 0
    with FmuTwin(tmp_path / "axis" / "twin.toml") as source:
        recording = Recording.read(log, source)
    np.testing.assert_allclose(recording.time, runs[0].time, atol=1e-9)
    for name in ("reference", "position", "torque_command"):
        np.testing.assert_allclose(recording.signal(name), runs[0].signal(name), atol=1e-9)


@pytest.mark.parametrize(
    ("rename", "arguments", "message"),
    [
        ({"Time_ms": "tick"}, (), "no clock among the columns tick, SetPos_deg, ActPos_deg"),
        ({"SetPos_deg": "a"}, (), "looks like reference, which drives the FMU's input ctl.phiRef"),
        ({"ActPos_deg": "b", "ActTorque_Nm": "c"}, (), "of the FMU (position, velocity, "),
        ({"ActTorque_Nm": "enc_deg"}, (), "ActPos_deg and enc_deg may both be position (enc.phi)"),
        ({}, ("--set", "position=ActPoss_deg"), "no column 'ActPoss_deg' for 'position'; did you"),
        ({}, ("--set", "postion=ActPos_deg"), "no signal 'postion'; did you mean 'position'?"),
        ({}, ("--preset", "odrve"), "no preset 'odrve'; did you mean 'odrive'"),
    ],
)
def test_what_it_cannot_guess_is_one_line_with_the_flag_that_tells_it(
    bench: Path,
    tmp_path: Path,
    rename: dict[str, str],
    arguments: tuple[str, ...],
    message: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    text = Path("run0.csv").read_text()
    for old, new in rename.items():
        text = text.replace(old, new, 1)
    log = tmp_path / "log.csv"
    log.write_text(text)
    assert run("init", "AX7.fmu", log, "--out", tmp_path / "axis", *arguments) == 2
    said = capsys.readouterr().err
    assert message in said
    assert said.count("\n") == 1
    assert not (tmp_path / "axis").exists()


def test_an_fmu_that_has_no_usual_output_is_told_by_its_own(
    bench: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    controller = models_folder() / "cascade_p_pi.fmu"
    flags = ("--set", "reference=SetPos_deg", "--out", tmp_path / "axis")
    assert run("init", controller, "run0.csv", *flags) == 2
    assert "an output of the FMU (u, velocity_reference)" in capsys.readouterr().err


def test_files_that_are_there_are_kept(
    bench: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "twin.toml").write_text("mine")
    assert run("init", "AX7.fmu", "run0.csv", "--out", tmp_path) == 2
    assert "is there already; give another --out" in capsys.readouterr().err
    assert (tmp_path / "twin.toml").read_text() == "mine"


class Terminal(StringIO):
    def isatty(self) -> bool:
        return True


def test_at_a_terminal_it_asks_and_enter_takes_the_guess(
    bench: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = Path("run0.csv").read_text().replace("SetPos_deg", "a", 1)
    log = tmp_path / "log.csv"
    log.write_text(text)
    # time, reference (two slips first), position, velocity, torque_command
    answers = "\naa\na [Nm]\na [deg]\n\n-\n\n"
    monkeypatch.setattr(sys, "stdin", Terminal(answers))
    assert run("init", "AX7.fmu", log, "--out", tmp_path / "axis") == 0
    said = capsys.readouterr().out
    assert "log.csv has no column 'aa' for 'reference'; did you mean 'a'?" in said
    assert "[Nm] is no unit of 'reference'; expected [rad] or another of its quantity" in said
    text = (tmp_path / "axis" / "twin.toml").read_text()
    assert 'reference = { column = "a", unit = "deg" }\n' in text
    assert '"ActPos_deg", unit = "deg" }  # guess: by the column\'s name' in text


def test_a_known_loggers_columns_come_from_its_preset(
    bench: Path, runs: list[Recording], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    turns = {name: runs[0].signal(name) / (2.0 * np.pi) for name in ("reference", "position")}
    log = write_csv(
        tmp_path / "odrive.csv",
        {
            "time": runs[0].time,
            "axis0.controller.input_pos": turns["reference"],
            "axis0.encoder.pos_estimate": turns["position"],
            "axis0.controller.input_torque": runs[0].signal("torque_command"),
        },
    )
    assert run("init", "AX7.fmu", log, "--preset", "odrive", "--out", tmp_path / "axis") == 0
    assert "guess: preset odrive" in capsys.readouterr().out
    with FmuTwin(tmp_path / "axis" / "twin.toml") as source:
        recording = Recording.read(log, source)
    np.testing.assert_allclose(recording.signal("position"), runs[0].signal("position"), atol=1e-7)


def test_a_plant_without_a_loop_gets_a_twin_file_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    time = np.linspace(0.0, 0.999, 1000)
    with FmuTwin(models_folder() / "motor_bench.toml") as source:
        drive = Recording(time=time, signals={"current": np.sin(20.0 * time)})
        turned = source.run({}, drive).signal("position")
    columns = {"time [s]": time, "iq [A]": drive.signal("current"), "angle [rad]": turned}
    log = write_csv(tmp_path / "log.csv", columns)
    assert run("init", models_folder() / "motor_bench.fmu", log, "--out", tmp_path / "axis") == 0
    assert "no study" in capsys.readouterr().out
    assert not (tmp_path / "axis" / "study.toml").exists()
    assert FmuTwin(tmp_path / "axis" / "twin.toml").file.inputs


def test_the_overlay_shows_each_signal_and_loads_nothing(bench: Path, tmp_path: Path) -> None:
    assert run("init", "AX7.fmu", "run0.csv", "--out", tmp_path) == 0
    page = (tmp_path / "overlay.html").read_text()
    assert page.count("<figure>") == 2
    assert page.count('class="line recorded"') == 2 + 2  # one in each legend
    assert not re.search(r'(src|href)="?https?:', page)


@pytest.mark.slow
def test_first_verdict_of_a_log_in_ms_and_degrees(tmp_path: Path, bench: Path) -> None:
    logs = [
        write_csv(tmp_path / f"run{k}.csv", in_ms_and_degrees(one))
        for k, one in enumerate(axis_runs())
    ]
    assert run("init", "AX7.fmu", *logs, "--out", tmp_path / "axis") == 0
    twin = tmp_path / "axis" / "twin.toml"
    assert run("diagnose", twin, *logs, "--out", tmp_path / "found") == 0
    found = json.loads((tmp_path / "found" / "diagnosis.json").read_text())
    (effect,) = found["effects"]
    assert effect["name"] == "coulomb_friction"
    assert effect["parameters"]["level"]["value"] == pytest.approx(0.2, rel=0.02)
