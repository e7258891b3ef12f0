"""Text files as oscilloscopes and LabVIEW write them, in the layouts that their manuals show."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gmfbo.errors import RecordingError
from gmfbo.recordings import Recording, SignalSpec
from tests.recordings.twin_words import TwinWords

VOLTS = np.array([0.25, 0.5, -1.0, 2.0])
TIMES = np.array([-0.002, -0.001, 0.0, 0.001])
PAIRS = list(zip(TIMES, VOLTS, strict=True))

# Each holds TIMES and VOLTS on channel 1.
LAYOUTS = {
    "Rigol, start and increment": "X,CH1,Start,Increment,\nSequence,Volt,-2.0e-03,1.0e-03\n"
    + "".join(f"{k},{v:e},\n" for k, v in enumerate(VOLTS)),
    "Rigol, later": "CH1(V),t0 = -2e-3, tInc = 1e-3,\n" + "".join(f"{v:e},,\n" for v in VOLTS),
    "Rigol, later with times": "Time(s),CH1(V),t0 = -2e-3, tInc = 1e-3,\n"
    + "".join(f"{t:e},{v:e},,\n" for t, v in PAIRS),
    "Keysight InfiniiVision": "x-axis,CH1\nsecond,Volt\n" + "".join(f"{t},{v}\n" for t, v in PAIRS),
    "Keysight InfiniiVision, numbered": "x-axis,1\nsecond,Volt\n"
    + "".join(f"{t},{v}\n" for t, v in PAIRS),
    "Rohde & Schwarz RTB": "in s,CH1 in V\n" + "".join(f"{t:E},{v:E}\n" for t, v in PAIRS),
    "Keysight Infiniium": "Type:,raw\nPoints:,4\nXInc:,1.0E-03\nXOrg:,-2.0E-03\nYUnits:,Volt\n"
    "XUnits:,second\nData:,\n" + "".join(f"{v:E}\n" for v in VOLTS),
    "Rohde & Schwarz RTM": "[s],CH1[V]\n" + "".join(f"{t:E},{v:E}\n" for t, v in PAIRS),
    "Siglent": "Record Length,Analog:4\nSample Interval,Analog:1e-3\nVertical Units,CH1:V\n"
    "Source,CH1\nSecond,Volt\n" + "".join(f"{t:.6f},{v:.6f}\n" for t, v in PAIRS),
    "Tektronix, later": "Model,MSO44\nLabel,\nWaveform Type,ANALOG\nHorizontal Units,s\n"
    "Sample Interval,1.0E-3\nRecord Length,4\nVertical Units,V\n,\nLabels,\nTIME,CH1\n"
    + "".join(f"{t},{v}\n" for t, v in PAIRS),
    "Tektronix, labels beside": "".join(
        f"{label},{t:.9f},{v:.6e},\n"
        for label, (t, v) in zip(
            ("Record Length,4,Points", "Sample Interval,1,ms", "Source,CH1,", "Vertical Units,V,"),
            PAIRS,
            strict=True,
        )
    ),
}  # fmt: skip


def write(folder: Path, text: str, name: str = "scope.csv") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("text", LAYOUTS.values(), ids=LAYOUTS.keys())
def test_each_layout_holds_the_same_samples(tmp_path: Path, text: str) -> None:
    recording = Recording.read(write(tmp_path, text))
    np.testing.assert_allclose(recording.time, TIMES, atol=1e-15)
    (values,) = recording.signals.values()
    np.testing.assert_array_equal(values, VOLTS)


def test_two_channels_beside_their_labels(tmp_path: Path) -> None:
    labels = ("Record Length,4,Points", "Source,CH{},", "Vertical Units,V,", ",,")
    rows = [
        ",".join(f"{label.format(k)},{t:.9f},{k * v:.6e}" for k in (1, 2))
        for label, (t, v) in zip(labels, PAIRS, strict=True)
    ]
    recording = Recording.read(write(tmp_path, "\n".join(rows) + "\n"))
    np.testing.assert_array_equal(recording.signal("CH2"), 2 * VOLTS)
    assert recording.units == {"CH1": "V", "CH2": "V"}


def test_start_alone_is_a_column_like_any_other(tmp_path: Path) -> None:
    """Negative control: without an increment nothing is known about the clock."""
    recording = Recording.read(write(tmp_path, "time,Start\n0,5\n1,6\n"))
    np.testing.assert_array_equal(recording.signal("Start"), [5.0, 6.0])


RTO = (  # R&S RTO6 User Manual, tables of the header file
    "ResultType:Waveform:\nResolution:5e-4:\nSignalResolution:1e-3:\nSource:Ch1:\n"
    "SignalFormat:FLOAT:\nXStart:-0.002:\nXStop:0.002:\nHardwareXStart:-0.002:\n"
    "SignalHardwareRecordLength:4:\nInterleavedTraceCount:1:\nNumberOfAcquisitions:1:\n"
    "VerticalOffset:0:V:\nTimestamp:2026-01-02 03:04:05:\n"
)
TWO = (
    "MultiChannelExport:On:\nMultiChannelExportState:4:On:Off:On:Off:\n"
    "MultiChannelSource:4:Ch1:None:Ch3:None:\nMultiChannelVerticalOffset:4:0:0:0:0:V:\n"
)


def rto(folder: Path, header: str, rows: list[str]) -> Path:
    write(folder, header, "run.csv")
    return write(folder, "".join(f"{row}\n" for row in rows), "run.Wfm.csv")


def test_a_pair_of_rohde_and_schwarz_is_read_by_its_header(tmp_path: Path) -> None:
    recording = Recording.read(rto(tmp_path, RTO, [f"{v:e}" for v in VOLTS]))
    np.testing.assert_allclose(recording.time, TIMES, atol=1e-15)
    np.testing.assert_array_equal(recording.signal("Ch1"), VOLTS)
    assert recording.units["Ch1"] == "V"


@pytest.mark.parametrize("between", [",", ";", "\t", " "])
@pytest.mark.parametrize("timed", [False, True], ids=["even", "with times"])
def test_a_pair_with_two_channels_names_those_that_were_exported(
    tmp_path: Path, between: str, timed: bool
) -> None:
    cells = [([f"{t:e}"] if timed else []) + [f"{v:e}", f"{2 * v:e}"] for t, v in PAIRS]
    recording = Recording.read(rto(tmp_path, RTO + TWO, [between.join(row) for row in cells]))
    np.testing.assert_allclose(recording.time, TIMES, atol=1e-15)
    np.testing.assert_array_equal(recording.signal("Ch1"), VOLTS)
    np.testing.assert_array_equal(recording.signal("Ch3"), 2 * VOLTS)


def test_samples_before_the_start_of_a_pair_are_placed_by_the_hardware_start(
    tmp_path: Path,
) -> None:
    """They serve filters; a file without them begins at XStart."""
    header = RTO.replace("\nXStart:-0.002", "\nXStart:0.0")
    samples = [f"{v:e}" for v in VOLTS]
    assert Recording.read(rto(tmp_path, header, samples)).time[0] == -0.002
    assert Recording.read(rto(tmp_path, header, samples[1:])).time[0] == 0.0


@pytest.mark.parametrize(
    ("header", "row", "words"),
    [
        (RTO, "0.1,0.2,0.3", "expected 1 values a line .Ch1., as its header states, got 3"),
        (RTO.replace("Acquisitions:1", "Acquisitions:5"), "0.1", "expected one acquisition, got 5"),
    ],
)
def test_a_pair_that_does_not_fit_together_is_refused(
    tmp_path: Path, header: str, row: str, words: str
) -> None:
    with pytest.raises(RecordingError, match=words):
        Recording.read(rto(tmp_path, header, [row] * 4))


def test_half_a_pair_is_refused_with_the_name_of_the_other(tmp_path: Path) -> None:
    values = rto(tmp_path, RTO, [f"{v:e}" for v in VOLTS])
    with pytest.raises(RecordingError, match=r"the header of .* name its values, 'run.Wfm.csv'"):
        Recording.read(tmp_path / "run.csv")
    (tmp_path / "run.csv").unlink()
    with pytest.raises(
        RecordingError, match=r"expected its header 'run\.csv' beside it; copy both"
    ):
        Recording.read(values)


def test_a_table_of_that_name_with_a_header_of_its_own_is_a_table(tmp_path: Path) -> None:
    """Negative control."""
    path = write(tmp_path, "time [s],CH1 [V]\n0,1\n1,2\n", "run.Wfm.csv")
    np.testing.assert_array_equal(Recording.read(path).signal("CH1"), [1.0, 2.0])


HEAD = (
    "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nDecimal_Separator\t{point}\n"
    "X_Columns\t{columns}\nDate\t2016/08/11\nTime\t14:37:48.2010002\n***End_of_Header***\t\n\t\n"
)
SEGMENT = (
    "Channels\t2\t\t\nSamples\t4\t4\nY_Unit_Label\tVolts\tAmp\nX0\t-2e-3\t-2e-3\n"
    "Delta_X\t1e-3\t1e-3\n***End_of_Header***\t\t\n"
)


def lvm(columns: str, point: str = ".") -> str:
    names, cells = {
        "One": ("X_Value\tu\ti\tComment", "{t}\t{v}\t{i}"),
        "No": ("X_Value\tu\ti\tComment", "\t{v}\t{i}"),
        "Multi": ("X_Value\tu\tX_Value\ti\tComment", "{t}\t{v}\t{t}\t{i}"),
    }[columns]
    rows = [cells.format(t=t, v=v, i=2 * v).replace(".", point) for t, v in PAIRS]
    return HEAD.format(columns=columns, point=point) + SEGMENT + "\n".join([names, *rows]) + "\n"


@pytest.mark.parametrize("columns", ["One", "No", "Multi"])
@pytest.mark.parametrize("point", [".", ","])
def test_a_labview_file_is_read_in_all_its_layouts(
    tmp_path: Path, columns: str, point: str
) -> None:
    recording = Recording.read(write(tmp_path, lvm(columns, point), "run.lvm"))
    np.testing.assert_allclose(recording.time, TIMES, atol=1e-15)
    np.testing.assert_array_equal(recording.signal("u"), VOLTS)
    np.testing.assert_array_equal(recording.signal("i"), 2 * VOLTS)
    assert recording.start_time.startswith("2016-08-11T14:37:48.201")


def test_segments_of_a_labview_file_follow_each_other(tmp_path: Path) -> None:
    text = lvm("One") + "\n" + lvm("One").partition("\t\n\t\n")[2]
    recording = Recording.read(write(tmp_path, text, "run.lvm"))
    np.testing.assert_allclose(recording.time, -0.002 + 0.001 * np.arange(8), atol=1e-15)
    np.testing.assert_array_equal(recording.signal("u"), np.tile(VOLTS, 2))


def test_text_in_a_cell_of_a_labview_file_is_told_with_its_line(tmp_path: Path) -> None:
    text = lvm("One").replace("0.5\t1.0", "bad\t1.0")
    with pytest.raises(RecordingError, match=r"line 18, channel 'u': .* got 'bad'"):
        Recording.read(write(tmp_path, text, "run.lvm"), TwinWords((SignalSpec("u", "u"),)))


def test_a_labview_file_without_a_segment_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="expected a segment with a line 'X_Value'"):
        Recording.read(write(tmp_path, HEAD.format(columns="One", point="."), "run.lvm"))
