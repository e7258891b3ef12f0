"""Write a recording as CSV text of our own format."""

from __future__ import annotations

import json

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import RecordingError
from gmfbo.recordings.csv.head import OWN, RESERVED, RUN_KEYS
from gmfbo.recordings.csv.header import header_cell
from gmfbo.recordings.recording import Recording, Trajectory


def csv_text(recording: Recording, version: str) -> str:
    """CSV text with numbers in full, so that reading gives the same bits; NaN is blank.

    Raises
    ------
    RecordingError
        A name would not be read back unchanged.
    """
    columns = {**recording.signals, **recording.schedules}
    if len(columns) < len(recording.signals) + len(recording.schedules) or "time" in columns:
        raise RecordingError("expected a name for one column only, and none called 'time'; rename")
    header = [header_cell("time", "s")]
    header += [header_cell(name, recording.units.get(name, "")) for name in columns]
    texts = [_cells(values) for values in (recording.time, *columns.values())]
    rows = [",".join(row) for row in zip(*texts, strict=True)]
    return "\n".join([*_head_lines(recording, version), ",".join(header), *rows, ""])


def _cells(values: NDArray[np.float64]) -> list[str]:
    return ["" if value != value else repr(value) for value in values.tolist()]


def _head_lines(recording: Recording, version: str) -> list[str]:
    """Lines above the header, without line ends; refuses a name that cannot stand there."""
    lines = [f"# gmfbo = {version}"]
    if not is_ours(recording):
        lines.append(f"# {OWN}logger = {json.dumps('other')}")
    if recording.use is not None:
        # The repr of a NumPy number includes its type.
        first, last = map(float, recording.use)
        lines.append(f"# use = {first!r}:{last!r}")
    if recording.start_time:
        lines.append(f"# start_time = {recording.start_time}")
    if isinstance(recording, Trajectory):
        for key in RUN_KEYS:
            lines.append(f"# {OWN}{key} = {json.dumps(getattr(recording, key))}")
    lines += [f"# {OWN}schedule = {name}" for name in recording.schedules]
    for name, value in recording.parameters.items():
        if name in RESERVED or name.startswith(OWN) or name != name.strip() or "\n" in name:
            raise RecordingError(
                f"parameter '{name}' cannot be written into a CSV file, where this name has "
                "another meaning; write .h5 instead"
            )
        lines.append(f"# {name} = {float(value)!r}")
    return lines


def is_ours(recording: Recording) -> bool:
    """Whether gmfbo made these signals, so that they follow its convention of time.

    Another logger's recording stays its own when gmfbo writes it again.
    """
    return isinstance(recording, Trajectory) or bool(recording.written_by)
