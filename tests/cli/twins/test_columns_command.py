"""`gmfbo columns` and the mapping that it saves, as a person meets them."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from gmfbo import FmuTwin, Recording
from gmfbo.cli import main
from gmfbo.errors import TwinFileError
from gmfbo.recordings.columns.column_mapping import ColumnMapping, MappedColumn
from gmfbo.sources.export.augmented_file import augmented_twin_file
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.twin_file.column_file import ColumnFile, column_file_text, column_mapping
from gmfbo.sources.twin_file.twin_file import TwinFile

ROWS = 400
ANGLE = 0.3 * np.sin(np.arange(ROWS) * 0.02)


def run(*arguments: object) -> int:
    return main([str(argument) for argument in arguments])


@pytest.fixture
def twin(tmp_path: Path) -> Path:
    for ending in ("toml", "fmu"):
        shutil.copy(models_folder() / f"servo_axis.{ending}", tmp_path)
    return tmp_path / "servo_axis.toml"


@pytest.fixture
def log(tmp_path: Path) -> Path:
    lines = ["Takt;AX7.SetPos;AX7.ActPos;AX7.ActTorque"]
    for k, angle in enumerate(ANGLE):
        cells = [k, f"{angle:.9f}", f"{np.rad2deg(angle):.9f}", f"{100.0 * angle:.6f}"]
        lines.append(";".join(map(str, cells)).replace(".", ","))
    # Names keep their points, numbers have commas.
    path = tmp_path / "log.csv"
    path.write_text("\n".join(lines))
    return path


SETTINGS = (
    "--set", "time=Takt [ms]", "--set", "reference=AX7.SetPos",
    "--set", "position=AX7.ActPos [deg]", "--set", "torque_command=AX7.ActTorque [mNm]",
)  # fmt: skip


def use(twin: Path, entry: str) -> None:
    twin.write_text(twin.read_text().replace("\nstep =", f"\n{entry}\nstep =", 1))


def test_a_mapping_saved_once_reads_the_next_recordings(
    twin: Path, log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("columns", twin, log, *SETTINGS, "--save", tmp_path / "logger.toml") == 0
    shown = capsys.readouterr().out
    entry = shown.splitlines()[-1]
    assert entry == 'columns = "logger.toml"'
    use(twin, entry)
    with FmuTwin(twin) as source:
        recording = Recording.read(log, source)
    np.testing.assert_allclose(recording.time, np.arange(ROWS) * 1e-3, atol=1e-12)
    np.testing.assert_allclose(recording.signal("position"), ANGLE, atol=1e-10)
    np.testing.assert_allclose(recording.signal("torque_command"), 0.1 * ANGLE, atol=1e-9)
    assert run("simulate", twin, "--reference", log, "--out", tmp_path / "out.csv") == 0
    fit = capsys.readouterr().out
    assert "position" in fit
    assert "torque_command" in fit


def test_without_settings_it_lists_columns_guesses_and_what_is_missing(
    twin: Path, log: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("columns", twin, log) == 0
    shown = capsys.readouterr().out
    assert "log.csv: 4 columns, 400 rows" in shown
    assert "position? (a guess)" in next(line for line in shown.splitlines() if "ActPos" in line)
    assert "not found: the clock; say where with --set 'time=COLUMN [ms]'" in shown
    assert "not found: reference, position, torque_command" in shown


def test_a_name_of_ones_own_is_kept(twin: Path, log: Path, tmp_path: Path) -> None:
    saved = tmp_path / "own.toml"
    own = (*SETTINGS, "--set", "winding=AX7.ActTorque")
    assert run("columns", twin, log, *own, "--save", saved) == 0
    assert 'winding = "AX7.ActTorque"' in saved.read_text()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--set", "position=AX7.ActPoss"), "did you mean 'AX7.ActPos'?"),
        (("--set", "position"), "expected NAME=COLUMN, such as position=ActPos, got 'position'"),
        (("--set", "position=AX7.ActPos [blinks]"), "unit [blinks] of 'position' is not known"),
        (("--set", "position=AX7.ActPos [Nm]"), "[Nm] is no unit of 'position'; expected [rad]"),
        (("--set", "time=AX7.ActPos [rad]"), "[rad] is no unit of 'time'; expected [s]"),
        (("--preset", "vesc"), "--preset vesc: log.csv has none of its columns (current_motor,"),
        (("--set", "positon=AX7.ActPos"), "the twin has no 'positon'; did you mean 'position'?"),
        (("--set", "Inertia=AX7.ActPos"), "the twin has no 'Inertia'; did you mean 'inertia'?"),
        (("--dialect", "twincat"), "no dialect 'twincat'; did you mean 'twincat_scope'?"),
        (("--save", "out.csv"), "--save: expected a file ending in .toml, got 'out.csv'"),
        (("--save", "out.toml"), "expected a column 'time'"),
    ],
)
def test_bad_input_is_one_line(
    twin: Path,
    log: Path,
    arguments: tuple[str, ...],
    message: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run("columns", twin, log, *arguments) == 2
    said = capsys.readouterr().err
    assert message in said
    assert said.count("\n") == 1


def test_a_table_in_the_twin_file_says_the_same_as_a_file(twin: Path, tmp_path: Path) -> None:
    shared = tmp_path / "logger.toml"
    columns = {
        "time": MappedColumn("Takt", unit="ms"),
        "position": MappedColumn("AX7.ActPos", unit="deg", scale=0.5, offset=1.0),
        "ctl.Kp": MappedColumn('a "b" = c'),
    }
    shared.write_text(column_file_text(columns, "decimal_comma", {"speed": "v"}, "by a test"))
    read = ColumnFile.read(shared)
    mapping = ColumnMapping(columns, "decimal_comma")
    assert column_mapping(read.columns, read.dialect) == mapping
    plain_hash = FmuTwin(twin).content_hash
    text = twin.read_text()
    use(twin, 'columns = "logger.toml"')
    assert FmuTwin(twin).column_mapping() == mapping
    # How a logger names its columns changes no run.
    assert FmuTwin(twin).content_hash == plain_hash
    inside = shared.read_text().split("\n", 2)[2]
    twin.write_text(text.replace("\nstep =", '\ndialect = "decimal_comma"\nstep =', 1) + inside)
    assert FmuTwin(twin).column_mapping() == mapping


def test_the_file_of_an_augmented_twin_keeps_the_mapping(twin: Path, tmp_path: Path) -> None:
    (tmp_path / "logger.toml").write_text(
        'dialect = "plain"\n[columns]\ntime = "Takt"\nposition = { column = "p", unit = "deg" }\n'
    )
    use(twin, 'columns = "logger.toml"')
    file = TwinFile.read(twin)
    text = augmented_twin_file(file, "augmented.fmu", 1e-3, "note", {})
    again = TwinFile.parse(text, "augmented.toml")
    assert (again.columns, again.dialect) == (file.columns, "plain")


@pytest.mark.parametrize(
    ("mapping", "message"),
    [
        (None, r"no column mapping at '.*logger\.toml' \(No such file"),
        ("[columns", r"logger\.toml: not valid TOML"),
        ("[columns]\nposition = 3\n", r"\[columns\] 'position'"),
        ('dialect = "excel"\n', r"dialect: expected 'auto', 'plain', 'decimal_comma'"),
        (
            '[columns]\nposition = { column = "a", unit = "blinks" }\n',
            r"unit: 'blinks' is not known",
        ),
        (
            '[columns]\ntorque_comand = "a"\n',
            r"\[columns\] 'torque_comand': no such signal or parameter; did you mean",
        ),
    ],
)
def test_a_mapping_that_cannot_be_used_is_refused(
    twin: Path, tmp_path: Path, mapping: str | None, message: str
) -> None:
    if mapping is not None:
        (tmp_path / "logger.toml").write_text(mapping)
    use(twin, 'columns = "logger.toml"')
    with pytest.raises(TwinFileError, match=message):
        FmuTwin(twin)


def test_names_of_other_twins_are_no_mistake(twin: Path, tmp_path: Path) -> None:
    (tmp_path / "logger.toml").write_text('[columns]\nposition_2 = "a"\ncurrent = "b"\n')
    use(twin, 'columns = "logger.toml"')
    assert set(FmuTwin(twin).column_mapping().columns) == {"position_2", "current"}


def comments(text: str) -> list[str]:
    return [line.partition("#")[2] for line in text.splitlines() if "#" in line]


@pytest.mark.parametrize("line_end", ["\n", "\r\n"])
def test_saved_into_the_twin_file_it_keeps_every_other_line(
    twin: Path, log: Path, line_end: str, capsys: pytest.CaptureFixture[str]
) -> None:
    before = twin.read_text().replace("\n", line_end)
    twin.write_bytes(before.encode())
    assert run("columns", twin, log, *SETTINGS, "--save", twin) == 0
    assert capsys.readouterr().out.endswith(f"written: [columns] of {twin}\n")
    after = twin.read_bytes().decode()
    assert after.startswith(before.rstrip())
    with FmuTwin(twin) as source:
        recording = Recording.read(log, source)
    np.testing.assert_allclose(recording.signal("position"), ANGLE, atol=1e-10)
    # A second time: one entry changes, and nothing else does.
    text = twin.read_bytes().decode().replace('unit = "deg" }', 'unit = "deg" } # by the drive')
    twin.write_bytes(text.encode())
    assert run("columns", twin, log, "--set", "position=AX7.ActPos [mrad]", "--save", twin) == 0
    again = twin.read_bytes().decode()
    assert again == text.replace('"deg" } #', '"mrad" } #')
    with FmuTwin(twin) as source:
        recording = Recording.read(log, source)
    np.testing.assert_allclose(recording.signal("position"), np.rad2deg(ANGLE) * 1e-3, atol=1e-10)


def test_a_mapping_file_is_still_read_and_goes_into_the_twin_file_where_asked(
    twin: Path, log: Path, tmp_path: Path
) -> None:
    logger = tmp_path / "logger.toml"
    assert run("columns", twin, log, *SETTINGS, "--dialect", "plain", "--save", logger) == 0
    use(twin, 'columns = "logger.toml"')
    mapping = FmuTwin(twin).column_mapping()
    assert mapping.columns["time"] == MappedColumn("Takt", "ms")
    told = comments(twin.read_text())
    assert run("columns", twin, log, "--save", twin) == 0
    assert set(told) <= set(comments(twin.read_text()))
    logger.unlink()
    assert FmuTwin(twin).column_mapping() == mapping


def test_guesses_are_comments_in_the_twin_file_and_stand_there_once(twin: Path, log: Path) -> None:
    told = ("--set", "time=Takt [ms]", "--set", "reference=AX7.SetPos")
    for _ in range(2):
        assert run("columns", twin, log, *told, "--save", twin) == 0
    lines = [line for line in twin.read_text().splitlines() if "a guess" in line]
    assert lines == [
        f'# {name} = "AX7.{column}"  # a guess; remove the # if it is right'
        for name, column in (("position", "ActPos"), ("torque_command", "ActTorque"))
    ]
    assert set(FmuTwin(twin).column_mapping().columns) == {"time", "reference"}


def test_a_file_that_is_no_mapping_is_not_overwritten(
    twin: Path, log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = tmp_path / "study.toml"
    other.write_text('name = "monday"\n')
    assert run("columns", twin, log, *SETTINGS, "--save", other) == 2
    assert "is there and would be lost" in capsys.readouterr().err
    assert other.read_text() == 'name = "monday"\n'
