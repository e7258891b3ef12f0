"""Event log of a study: one line an event, each with a checksum.

A line is JSON with the keys `event`, `time` (UTC), the event's own fields and, last, `crc32`:
the CRC-32, eight hex digits, of the line without that key. A line left unfinished by a killed
process fails its checksum; it is skipped and reported, and the others stay valid.
"""

from __future__ import annotations

import contextlib
import json
import os
import re
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from gmfbo.files.durable import BINARY, write_fully
from gmfbo.recordings.store.seal import wrong_bit

_SEPARATOR = ', "crc32": "'
_TAIL = len(_SEPARATOR) + 8 + 2


@dataclass(frozen=True)
class EventLines:
    """Events of a file, and the numbers of the lines (from 1) that are damaged."""

    events: list[dict[str, Any]]
    damaged: list[int]


def event_line(event: str, fields: Mapping[str, Any]) -> str:
    """One line of the file, without its end."""
    now = datetime.now(UTC).isoformat(timespec="milliseconds")
    body = json.dumps({"event": event, "time": now, **fields}, default=_plain)
    return f'{body[:-1]}{_SEPARATOR}{zlib.crc32(body.encode()):08x}"}}'


def parse_event_line(line: str) -> dict[str, Any] | None:
    """Event of one line; None where the line is damaged."""
    head, separator, tail = line.rpartition(_SEPARATOR)
    body = head + "}"
    if not separator or tail != f'{zlib.crc32(body.encode()):08x}"}}':
        return None
    try:
        parsed = json.loads(body)
    except (ValueError, RecursionError):
        return None
    return parsed if isinstance(parsed, dict) and "event" in parsed else None


def read_events(content: bytes) -> EventLines:
    """Read all lines, a torn last one included."""
    events, damaged = [], []
    # Texts in JSON hold no newline, so each newline ends an event.
    lines = content.decode("utf-8", errors="replace").split("\n")
    for number, line in enumerate(lines, start=1):
        if not line:
            continue
        event = parse_event_line(line)
        if event is None:
            damaged.append(number)
        else:
            events.append(event)
    return EventLines(events, damaged)


def mend_events(content: bytes) -> tuple[bytes, list[int]]:
    """Correct single wrong bits of damaged lines, found by their checksums.

    Returns
    -------
    tuple
        The content, and the numbers (from 1) of the lines that were mended.
    """
    lines = content.split(b"\n")
    mended = []
    for place, line in enumerate(lines):
        if line and parse_event_line(line.decode(errors="replace")) is None:
            corrected = _mended_line(line)
            if corrected is not None:
                lines[place] = corrected
                mended.append(place + 1)
    return b"\n".join(lines), mended


def _mended_line(line: bytes) -> bytes | None:
    separator = _SEPARATOR.encode()
    head, found, tail = line.rpartition(separator)
    places = range(8 * max(len(line) - _TAIL, 0), 8 * len(line))
    if found and re.fullmatch(rb"[0-9a-f]{8}", tail[:8]):
        body = wrong_bit(head + b"}", int(tail[:8], 16))
        # The checksum's own bits are tried one by one.
        places = places if body is None else range(k := 8 * body[0] + body[1], k + 1)
    for place in places:
        corrected = bytearray(line)
        corrected[place // 8] ^= 1 << place % 8
        if parse_event_line(corrected.decode(errors="replace")) is not None:
            return bytes(corrected)
    return None


def append_event(path: Path, line: str) -> None:
    """Append one line and sync it to the disk.

    Raises
    ------
    OSError
        The line could not be written whole; the file is unchanged.
    """
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND | BINARY, 0o666)
    try:
        size = os.fstat(descriptor).st_size
        torn = size > 0 and _last_byte(descriptor, size) != b"\n"
        try:
            write_fully(descriptor, (("\n" if torn else "") + line + "\n").encode())
            os.fsync(descriptor)
        except OSError:
            # A full disk may have taken half a line.
            with contextlib.suppress(OSError):
                os.ftruncate(descriptor, size)
            raise
    finally:
        os.close(descriptor)


def _last_byte(descriptor: int, size: int) -> bytes:
    os.lseek(descriptor, size - 1, os.SEEK_SET)
    return os.read(descriptor, 1)


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, Mapping):
        return dict(value)
    if isinstance(value, (set, frozenset)):
        return sorted(value)
    if isinstance(value, Path):
        return value.as_posix()
    raise TypeError(f"an event cannot hold a {type(value).__name__}")
