"""Text files as TwinCAT Scope exports them, in the layouts that its dialogue offers.

The layouts follow Beckhoff's description of the export and files that it made (TE13xx, Export to
CSV; TwinCAT 2 Scope): a key in front of each group of columns, whose place holds the time below.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gmfbo.errors import RecordingError
from gmfbo.recordings import Recording
from gmfbo.recordings.columns.column_mapping import ColumnMapping, MappedColumn
from gmfbo.recordings.recording import read_recording

ROWS, SLOW_ROWS = 60, 15  # 1 ms and 4 ms
FAST = np.round(np.sin(np.arange(ROWS) * 0.05), 6)
SLOW = np.round(np.cos(np.arange(SLOW_ROWS) * 0.2), 6)
FILETIME = 132959733843760000  # 2022-05-02 13:56:24.376 UTC, in 100 ns since 1601


def head(*, full: bool = True, one_clock_each: bool = False) -> list[list[str]]:
    names = ["SetPos", "ActPos"]
    groups = [[name] for name in names] if one_clock_each else [names]
    groups = [*groups, ["ActTorque"]]

    def row(key: str, value: dict[str, str]) -> list[str]:
        return [cell for group in groups for cell in (key, *(value[name] for name in group))]

    lines = [row("Name", {name: name for name in (*names, "ActTorque")})]
    if not full:
        return [*lines, []]
    top = [
        ["Name", "axis"],
        ["File", "C:\\scope.csv"],
        ["Starttime of export", str(FILETIME), "Montag, 2. Mai 2022", "15:56:24.376"],
        ["Endtime of export", str(FILETIME + 600000), "Montag, 2. Mai 2022", "15:56:24.436"],
        [],
        [],
    ]
    both = {"SetPos": "", "ActPos": "", "ActTorque": ""}
    return [
        *top,
        *lines,
        row("SymbolComment", both),
        row("SampleTime[ms]", {"SetPos": "1", "ActPos": "1", "ActTorque": "4"}),
        row("SymbolName", {name: f"MAIN.fbAxis.{name}" for name in both}),
        row("ScaleFactor", dict.fromkeys(both, "1")),
        row("Unit", {"SetPos": "(None)", "ActPos": "° (Angle)", "ActTorque": "Nm (Torque)"}),
        [],
    ]


def body(
    *, one_clock_each: bool = False, slow: str = "end", ticks: bool = False
) -> list[list[str]]:
    def clock(k: int) -> str:
        return str(FILETIME + 10_000 * k) if ticks else str(k)

    rows = []
    for k in range(ROWS):
        one, two = f"{FAST[k]}", f"{np.rad2deg(FAST[k]):.9f}"
        row = [clock(k), one, clock(k), two] if one_clock_each else [clock(k), one, two]
        if slow == "end" and k < SLOW_ROWS:  # the slower group ends early
            row += [clock(4 * k), f"{SLOW[k]}"]
        elif slow == "repeat":
            row += [clock(k - k % 4), f"{SLOW[k // 4]}"]
        elif slow == "blank":
            row += [clock(k), f"{SLOW[k // 4]}"] if k % 4 == 0 else ["", ""]
        rows.append(row)
    return rows


def export(path: Path, rows: list[list[str]], separator: str, decimal: str) -> Path:
    text = "\r\n".join(separator.join(row) for row in rows)
    if decimal == ",":
        text = "\r\n".join(
            line
            if line.startswith(("Name", "File", "Start", "End", "Symbol"))
            else line.replace(".", ",")
            for line in text.split("\r\n")
        )
    path.write_bytes(text.encode("utf-8-sig"))
    return path


def check(recording: Recording) -> None:
    position, torque = recording.signal("ActPos"), recording.signal("ActTorque")
    assert recording.time.size == ROWS
    np.testing.assert_allclose(recording.time, np.arange(ROWS) * 1e-3, atol=1e-12)
    np.testing.assert_allclose(recording.signal("SetPos"), FAST, atol=1e-12)
    np.testing.assert_allclose(position, FAST, atol=1e-10)
    assert np.flatnonzero(np.isfinite(torque)).tolist() == list(range(0, ROWS, 4))
    np.testing.assert_allclose(torque[::4], SLOW, atol=1e-12)
    assert recording.units == {"ActPos": "rad", "ActTorque": "N.m"}
    assert recording.start_time == "2022-05-02T13:56:24.376000+00:00"


@pytest.mark.parametrize(
    ("separator", "decimal"), [("\t", ","), ("\t", "."), (";", ","), (";", "."), (",", ".")]
)
@pytest.mark.parametrize("slow", ["end", "repeat", "blank"])
@pytest.mark.parametrize("one_clock_each", [False, True])
def test_each_layout_holds_the_same_numbers(
    tmp_path: Path, separator: str, decimal: str, slow: str, one_clock_each: bool
) -> None:
    rows = head(one_clock_each=one_clock_each) + body(one_clock_each=one_clock_each, slow=slow)
    if separator == ",":
        rows = [[cell for cell in row if not cell.startswith("Montag")] for row in rows]
    check(Recording.read(export(tmp_path / "scope.csv", [*rows, ["EOF"]], separator, decimal)))


def test_full_timestamps_are_seconds_since_the_first(tmp_path: Path) -> None:
    rows = head() + body(ticks=True, slow="end")
    check(Recording.read(export(tmp_path / "scope.txt", rows, "\t", ",")))


def test_a_header_of_names_only_is_enough(tmp_path: Path) -> None:
    path = export(tmp_path / "scope.csv", head(full=False) + body(), ",", ".")
    recording = Recording.read(path)
    np.testing.assert_allclose(recording.signal("ActTorque")[::4], SLOW, atol=1e-12)
    assert recording.units == {}


def test_a_comment_over_several_lines_is_passed_over(tmp_path: Path) -> None:
    path = export(tmp_path / "scope.csv", head() + body(), "\t", ".")
    text = path.read_text(encoding="utf-8-sig")
    text = text.replace("SymbolComment\t\t\t", "SymbolComment\t(* position\n\n17 in mm *)\t\t")
    path.write_text(text, encoding="utf-8")
    check(Recording.read(path))


def test_a_channel_is_found_by_its_symbol(tmp_path: Path) -> None:
    path = export(tmp_path / "scope.csv", head() + body(), "\t", ",")
    mapping = ColumnMapping(
        {"position": MappedColumn("MAIN.fbAxis.ActPos")}, dialect="twincat_scope"
    )
    recording = read_recording(path, mapping=mapping)
    np.testing.assert_allclose(recording.signal("position"), FAST, atol=1e-10)


def test_rows_of_markers_are_refused_with_their_line(tmp_path: Path) -> None:
    path = export(tmp_path / "scope.csv", [*head(), *body(), ["Marker", "x"]], "\t", ",")
    with pytest.raises(RecordingError, match=r"line 74: expected a time in milliseconds, got 'Mar"):
        Recording.read(path)


def test_the_dialect_by_name_refuses_an_ordinary_table(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    path.write_text("time,a\n0,1\n1,2\n")
    with pytest.raises(RecordingError, match="expected a TwinCAT Scope export with a line"):
        read_recording(path, mapping=ColumnMapping({}, dialect="twincat_scope"))


@pytest.mark.parametrize("text", ["1e308", "-0.0", "9" * 30])
def test_a_tick_that_is_none_is_told_with_its_line(tmp_path: Path, text: str) -> None:
    lines = ["Name,axis", f"Starttime of export,{'9' * 30}", "Name,SetPos", "SymbolName,a.b"]
    lines += [f"{FILETIME + 10000 * k},1.0" for k in range(4)]
    lines[6] = f"{text},1.0"
    path = tmp_path / "run.csv"
    path.write_text("\n".join([*lines, ""]), encoding="utf-8")
    with pytest.raises(RecordingError, match=r"line 7: expected a time in ticks of 100 ns .* got"):
        Recording.read(path)
    lines[6] = lines[6].replace(text, str(FILETIME + 20000))
    path.write_text("\n".join([*lines, ""]), encoding="utf-8")
    assert Recording.read(path).start_time == "", "a year beyond 9999"
