"""Valid and odd files of the foreign formats: HDF5, MAT, Parquet, MDF and TDMS."""

from __future__ import annotations

import io
import random
import tempfile
import warnings
from collections.abc import Callable
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any, Literal, cast

import h5py
import numpy as np
import scipy.io
from hypothesis import strategies as st

from gmfbo.recordings.store.pack import pack_study
from gmfbo.recordings.store.seal import without_seal
from gmfbo.recordings.store.study_folder import StudyStore
from gmfbo.recordings.store.trial_file import trial_image
from gmfbo.recordings.writing.hdf5_group import file_image, recording_content, write_content
from tests.fuzz.mutation import byte_changes
from tests.recordings.store.example_trials import example_trial

_ROWS = 40
TIME = np.arange(_ROWS) * 1e-3


def _odd_arrays() -> dict[str, Any]:
    """Values that a recording may hold where a vector of numbers is expected."""
    return {
        "flat": np.full(_ROWS, 3.0), "nan": np.full(_ROWS, np.nan), "inf": np.full(_ROWS, np.inf),
        "denormal": np.full(_ROWS, 5e-324), "huge": np.full(_ROWS, 1.7e308),
        "whole": np.arange(_ROWS), "unsigned": np.arange(_ROWS, dtype=np.uint64) + 2**63,
        "half": np.arange(_ROWS, dtype=np.float16), "truth": np.arange(_ROWS) % 2 == 0,
        "complex": np.arange(_ROWS) * 1j, "matrix": np.ones((_ROWS, 3)), "row": np.ones((1, _ROWS)),
        "cube": np.ones((_ROWS, 1, 1)), "short": np.ones(3), "one": np.float64(1.0),
        "empty": np.empty(0), "none": np.empty((0, _ROWS)), "text": "some text",
        "texts": ["a", "b"], "back": TIME[::-1], "still": np.zeros(_ROWS),
    }  # fmt: skip


_Maker = Callable[[dict[str, Any], random.Random], bytes]


def odd(make: _Maker) -> st.SearchStrategy[bytes]:
    """Files whose columns are odd arrays under likely names."""
    names = ["time", "t", "reference", "position", "speed", "log.time", "Ω", "a/b", "x" * 70, "."]

    def build(columns: list[tuple[str, str]], seed: int) -> bytes:
        arrays = _odd_arrays()
        chosen = {name: arrays[kind] for name, kind in columns}
        try:
            return make({"time": TIME, **chosen}, random.Random(seed))
        except Exception:  # the writer refuses what the format cannot hold
            return b""

    pairs = st.tuples(st.sampled_from(names), st.sampled_from(sorted(_odd_arrays())))
    return st.builds(build, st.lists(pairs, max_size=6), st.integers(0, 2**63)).filter(bool)


_MAT_LAYOUTS: list[dict[str, Any]] = [
    {"scope": {"time": TIME, "signals": {"values": TIME, "label": "reference"}}},
    {"reference": {"Name": "", "Time": TIME, "Data": TIME.reshape(1, 1, -1)}, "tout": TIME},
    {"run": {"X": {"Data": TIME}, "Y": {"Name": "m/reference", "Data": TIME, "XIndex": 1.0}}},
    {"ans": np.vstack([TIME, TIME])},
    {
        "Aclass": np.array(["Atrajectory", "1.1        ", "           ", "binNormal  "]),
        "name": np.array(["time     ", "reference"]),
        "description": np.array(["[s]  ", "[rad]"]),
        "dataInfo": np.array([[0, 1, 0, -1], [2, 2, 0, 0]], dtype=np.int32),
        "data_1": np.zeros((2, 1)),
        "data_2": np.column_stack([TIME, TIME]),
    },
]


def hdf5() -> st.SearchStrategy[bytes]:
    """Plain HDF5 files and files of ours."""
    return st.one_of(byte_changes(_hdf5_corpus()), odd(make_hdf5), odd(_odd_hdf5))


def mat_v5() -> st.SearchStrategy[bytes]:
    """MATLAB files of version 5 and 4."""
    columns = {"time": TIME, "reference": TIME, "s": {"x": TIME, "y": 1.0}}
    corpus = [make_mat(columns, random.Random(k)) for k in range(4)]
    corpus += [make_mat(layout, random.Random(k)) for layout in _MAT_LAYOUTS for k in range(2)]
    return st.one_of(byte_changes(corpus), odd(make_mat))


def mat_v73() -> st.SearchStrategy[bytes]:
    """MATLAB files of version 7.3: HDF5 behind a block of text."""
    corpus = [
        make_mat_v73({"time": TIME, "reference": TIME[None]}, random.Random(k)) for k in range(3)
    ]
    return st.one_of(byte_changes(corpus), odd(make_mat_v73))


def parquet() -> st.SearchStrategy[bytes]:
    """Parquet files."""
    columns = {"time": TIME, "reference": TIME, "n": np.arange(_ROWS)}
    corpus = [make_parquet(columns, random.Random(k)) for k in range(6)]
    return st.one_of(byte_changes(corpus), odd(make_parquet))


def mdf() -> st.SearchStrategy[bytes]:
    """MDF files of version 4 and 3."""
    corpus = [
        make_mdf({"reference": TIME, "b": np.arange(_ROWS)}, random.Random(k)) for k in range(5)
    ]
    return st.one_of(byte_changes(corpus), odd(make_mdf))


def tdms() -> st.SearchStrategy[bytes]:
    """TDMS files."""
    corpus = [make_tdms({"time": TIME, "reference": TIME}, random.Random(k)) for k in range(4)]
    return st.one_of(byte_changes(corpus), odd(make_tdms))


def stored_trials() -> st.SearchStrategy[bytes]:
    """Trial files of a study folder, with and without their seal."""
    whole = [trial_image(example_trial(number, rows=_ROWS)) for number in (1, 2, 3)]
    return st.one_of(byte_changes(whole), byte_changes([without_seal(image) for image in whole]))


def packed_studies() -> st.SearchStrategy[bytes]:
    """Packed studies, with and without their seal."""
    whole = [_packed()]
    return st.one_of(byte_changes(whole), byte_changes([without_seal(image) for image in whole]))


def event_files() -> st.SearchStrategy[bytes]:
    """Event lines of a study folder."""
    from gmfbo.recordings.store.events import event_line

    lines = [event_line("ask", {"number": k, "gains": {"a": float(k)}}) for k in range(5)]
    lines += [event_line("repair", {"damaged_lines": [2]}), event_line("Ω", {"text": "\n\ud800"})]
    return byte_changes(["\n".join([*lines, ""]).encode("utf-8", "surrogatepass")])


@cache
def _packed() -> bytes:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "a.study"
        with StudyStore.create(folder, 'name = "a"\n') as store:
            for number in (1, 2, 3):
                store.log("ask", number=number)
                store.write_trial(example_trial(number, rows=_ROWS))
        return pack_study(folder, Path(name) / "a.h5").read_bytes()


@cache
def _hdf5_corpus() -> list[bytes]:
    columns = {"time": TIME, "reference": TIME, "drive/iq": TIME, "n": np.arange(_ROWS)}
    plain = make_hdf5(columns, random.Random(0))
    packed = make_hdf5({"time": TIME, "a": TIME}, random.Random(3))
    trial = trial_image(example_trial(1, rows=_ROWS))
    content = recording_content(example_trial(3, rows=9).recording)
    run = file_image(lambda root: write_content(root, content))
    return [plain, packed, trial, run, _packed()]


def make_hdf5(columns: dict[str, Any], rng: random.Random) -> bytes:
    """Plain datasets, packed or not."""
    options = rng.choice([{}, {}, {"chunks": True, "compression": "gzip", "fletcher32": True}])

    def fill(root: Any) -> None:
        root.attrs["ctl.Kp"] = 90.0
        for name, values in columns.items():
            root.create_dataset(name, data=values, **(options if np.ndim(values) else {}))
            root[name].attrs["unit"] = rng.choice(["rad", b"N.m", 1.0, np.ones(3), "\ufffd", ""])

    return file_image(fill)


def _odd_hdf5(columns: dict[str, Any], rng: random.Random) -> bytes:
    """What HDF5 can hold beside plain datasets: links, foreign types, absurd sizes."""

    def fill(root: Any) -> None:
        for name, values in columns.items():
            root.create_dataset(name, data=values)
        for kind in rng.sample(_ODD_ITEMS, rng.randint(1, 4)):
            kind(root)
        if rng.random() < 0.3:
            root.attrs["layout"], root.attrs["signals"] = 1, rng.choice([["time"], 3, "time", b"x"])

    return file_image(fill)


def _huge(root: Any) -> None:
    root.create_dataset("huge", shape=(2 ** rng_size(root),), dtype="f8", chunks=(1024,))


def rng_size(root: Any) -> int:
    """Power of two: a gigabyte, or more than any machine has."""
    return 27 if len(root) % 2 else 45


def _types(root: Any) -> None:
    root["compound"] = np.zeros(_ROWS, dtype=[("a", "f8"), ("b", "S3")])
    root["big"] = np.arange(_ROWS, dtype=">f8")
    root["opaque"] = np.zeros(3, dtype="V5")
    root["texts"] = np.array(["a", "b"], dtype=h5py.string_dtype())
    root["references"] = np.array([root.ref], dtype=h5py.ref_dtype)
    root.create_dataset("ragged", (3,), dtype=h5py.vlen_dtype("f8"))
    root["kind"] = np.dtype("f8")
    root["nothing"] = h5py.Empty("f8")


def _links(root: Any) -> None:
    root["soft"] = h5py.SoftLink("/nowhere")
    root["outside"] = h5py.ExternalLink("/etc/passwd", "/")
    root["circle/again"] = root["/"]


def _outside(root: Any) -> None:
    root.create_dataset("stolen", (8,), "f8", external=[("/etc/passwd", 0, 64)])
    layout = h5py.VirtualLayout((4,), "f8")
    layout[:] = h5py.VirtualSource("/tmp/none.h5", "x", (4,))
    root.create_virtual_dataset("virtual", layout)


def _study(root: Any) -> None:
    root["trials/000001/x"] = 1.0
    root.attrs["packed_study"] = "x"


def _deep(root: Any) -> None:
    root["/".join(["d"] * 300)] = TIME


_ODD_ITEMS = [_huge, _types, _links, _outside, _study, _deep]


def make_mat(columns: dict[str, Any], rng: random.Random) -> bytes:
    """Version 5, packed or not, or 4."""
    written = io.BytesIO()
    chosen = {name.replace("/", "_"): values for name, values in columns.items()}
    version: Literal["4", "5"] = rng.choice(["5", "5", "5", "4"])
    if version == "4":
        chosen = {name: values for name, values in chosen.items() if not isinstance(values, dict)}
    elif rng.random() < 0.5:
        chosen["cells"] = np.array([1.0, "a"], dtype=object)
        chosen["log"] = {"time": TIME, "deeper": {"x": TIME}}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        scipy.io.savemat(
            cast("Any", written), chosen, format=version, do_compression=rng.random() < 0.5
        )
    return written.getvalue()


def make_mat_v73(columns: dict[str, Any], rng: random.Random) -> bytes:
    """HDF5 with MATLAB's attributes, behind 512 bytes of text."""

    def fill(root: Any) -> None:
        for name, values in columns.items():
            item = root.create_dataset(name, data=values)
            item.attrs["MATLAB_class"] = rng.choice([b"double", b"char", b"cell", "double", 3])
            if rng.random() < 0.1:
                item.attrs["MATLAB_empty"] = 1
        root["#refs#/a"] = TIME

    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "x.mat"
        with h5py.File(path, "w", userblock_size=512) as file:
            fill(file)
        content = bytearray(path.read_bytes())
    head = b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM"
    content[: len(head)] = head
    return bytes(content)


def make_parquet(columns: dict[str, Any], rng: random.Random) -> bytes:
    """Columns with metadata, nulls and other types."""
    import pyarrow as arrow
    from pyarrow import parquet as files

    arrays = {}
    for name, values in columns.items():
        array = arrow.array(np.ravel(values)[:_ROWS].tolist() if np.ndim(values) else [1.0] * _ROWS)
        arrays[name] = array
    kinds = ["timestamp", "decimal", "list", "words", "time", "null", "duration", "plain"]
    kind = rng.choice(kinds)
    whole = arrow.array(range(_ROWS))
    if kind in ("timestamp", "duration"):
        unit = rng.choice(["s", "ms", "us", "ns"])
        arrays["clock"] = whole.cast(getattr(arrow, kind)(unit))
    elif kind == "decimal":
        arrays["clock"] = whole.cast(arrow.decimal128(30, 2))
    elif kind == "list":
        arrays["clock"] = arrow.array([[1.0]] * _ROWS)
    elif kind == "words":
        arrays["clock"] = arrow.array(["a"] * _ROWS).dictionary_encode()
    elif kind == "time":
        arrays["clock"] = whole.cast(arrow.int32()).cast(arrow.time32("s"))
    elif kind == "null":
        arrays["clock"] = arrow.nulls(_ROWS)
    table = arrow.table(arrays)
    if rng.random() < 0.5:
        notes = {"ctl.Kp": "90.5", b"\xff": b"\xff", "start_time": "x"}
        table = table.replace_schema_metadata(notes)
    written = io.BytesIO()
    files.write_table(table, written, compression=rng.choice(["snappy", "gzip", "zstd", "none"]))
    return written.getvalue()


def make_mdf(columns: dict[str, Any], rng: random.Random) -> bytes:
    """One or two groups, with or without packing."""
    import asammdf

    signals = []
    for name, values in columns.items():
        array = np.asarray(values)
        if array.dtype.kind in "OU":
            array = np.full(_ROWS, b"text")
        elif array.ndim == 0 or len(array) != _ROWS:
            array = np.ones(_ROWS)
        conversion: Any = rng.choice([None, {"a": 2.0, "b": 1.0}])
        if array.dtype.kind in "SbcV" or array.ndim > 1:
            conversion = None
        signals.append(asammdf.Signal(array, TIME, name=name, unit="rad", conversion=conversion))
    version = rng.choice(["4.10", "4.11", "4.20", "3.30"])
    with tempfile.TemporaryDirectory() as name, asammdf.MDF(version=version) as file:
        file.start_time = datetime(2026, 1, 2, tzinfo=UTC)
        file.append(signals, acq_name="fast")
        file.append(signals[:1], acq_name="slow")
        path = Path(name) / "x.mf4"
        saved = file.save(path, overwrite=True, compression=rng.choice([0, 1, 2]))
        return Path(saved).read_bytes()


def make_tdms(columns: dict[str, Any], rng: random.Random) -> bytes:
    """Waveforms and plain channels."""
    from nptdms import ChannelObject, RootObject, TdmsWriter

    written = io.BytesIO()
    with TdmsWriter(written) as writer:
        objects = [RootObject({"ctl.Kp": 90.0, "who": "Eva"})]
        for name, values in columns.items():
            array = np.asarray(values)
            waveform = {"wf_increment": 1e-3, "wf_start_offset": 0.0} if rng.random() < 0.5 else {}
            objects.append(ChannelObject("g", name, array, {"unit_string": "rad", **waveform}))
        for _ in range(rng.choice([1, 3])):
            writer.write_segment(objects)
    return written.getvalue()
