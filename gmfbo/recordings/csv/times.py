"""Times written out in a column, or in two: dates, times of day, and pandas' durations.

Such as 00:00:01,250, 2026-01-02T03:04:05.250Z, 02.01.2026 03:04:05, 1/2/2026 3:04:05 PM (month
first, as always with AM and PM), 2016/08/11 15:37:48.375 and 0 days 00:00:01.250.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import date

import numpy as np
from numpy.typing import NDArray

_CLOCK = r"(?P<h>\d{1,3}):(?P<m>[0-5]?\d):(?P<s>[0-5]?\d)(?:[.,](?P<f>\d{1,12}))?"
_SHORT = re.compile(r"(?P<h>)(?P<m>\d{1,4}):(?P<s>[0-5]?\d)[.,](?P<f>\d{1,12})")
_ZONE = r"\s*(?:Z|[+-]\d\d:?\d\d)?"
_ISO = re.compile(rf"(?P<Y>\d{{4}})-(?P<M>\d\d)-(?P<D>\d\d)[T ]\s*{_CLOCK}{_ZONE}")
_DOTS = re.compile(rf"(?P<D>\d{{1,2}})\.(?P<M>\d{{1,2}})\.(?P<Y>\d{{4}})\s+{_CLOCK}")
_HALF = r"\s*(?P<half>[AaPp])\.?[Mm]\.?"
_HALF_DAY = re.compile(rf"{_CLOCK}{_HALF}")
_US = re.compile(rf"(?P<M>\d{{1,2}})/(?P<D>\d{{1,2}})/(?P<Y>\d{{4}})[ ,]\s*{_CLOCK}{_HALF}")
_YEAR_FIRST = re.compile(rf"(?P<Y>\d{{4}})/(?P<M>\d{{1,2}})/(?P<D>\d{{1,2}})[ ,]\s*{_CLOCK}")
_DURATION = re.compile(rf"(?P<days>-?\d+) days?,? (?P<sign>[+-]?){_CLOCK}")
_FORMS = (
    *(re.compile(_CLOCK), _SHORT, _ISO, _DOTS),
    *(_HALF_DAY, _US, _YEAR_FIRST, _DURATION),
)
_DATES = (
    re.compile(r"(?P<Y>\d{4})[-/](?P<M>\d{1,2})[-/](?P<D>\d{1,2})"),
    re.compile(r"(?P<D>\d{1,2})\.(?P<M>\d{1,2})\.(?P<Y>\d{4})"),
)
_TICKS_PER_S = 10**12
_DAY = 86400 * _TICKS_PER_S


def is_time(text: str) -> bool:
    """Whether a cell, without blanks around it, is a time of day or a date with a time."""
    return any(form.fullmatch(text) for form in _FORMS)


def read_times(texts: Sequence[str]) -> tuple[NDArray[np.float64], str] | None:
    """Read a column of times, all written in one way.

    Parameters
    ----------
    texts : sequence of str
        Cells; blank is not sampled.

    Returns
    -------
    tuple or None
        Seconds, shape (n,), since midnight or, with dates, since the first row; and the first
        row's date and time (ISO 8601), empty without dates. None where a cell is no time.
    """
    filled = [text for text in texts if text]
    form = next((form for form in _FORMS if filled and form.fullmatch(filled[0])), None)
    if form is None:
        return None
    ticks: list[int | None] = []
    for text in texts:
        found = form.fullmatch(text)
        if text and found is None:
            return None
        try:
            ticks.append(None if found is None else _ticks(found))
        except ValueError:
            return None  # the 31st of April
    dated = "Y" in form.groupindex
    if not dated and "days" not in form.groupindex:
        ticks = _past_midnight(ticks)
    # In whole picoseconds: floats of seconds since the year 1 would lose their decimals.
    zero = next(tick for tick in ticks if tick is not None) if dated else 0
    seconds = [np.nan if tick is None else (tick - zero) / _TICKS_PER_S for tick in ticks]
    return np.array(seconds, dtype=np.float64), _iso(form, filled[0]) if dated else ""


def read_date(text: str) -> str:
    """First day of a column of dates, 2026-01-02 or 02.01.2026, as ISO 8601; empty otherwise.

    1/2/2026 is a day of January or of February, and not read.

    Parameters
    ----------
    text : str
        A cell without blanks around it.
    """
    for form in _DATES:
        if found := form.fullmatch(text):
            try:
                return date(int(found["Y"]), int(found["M"]), int(found["D"])).isoformat()
            except ValueError:
                return ""
    return ""


def _past_midnight(ticks: list[int | None]) -> list[int | None]:
    """Times of day that go on where they fall by more than half a day: that is midnight."""
    days, last = 0, None
    going_on: list[int | None] = []
    for tick in ticks:
        if tick is not None:
            days += last is not None and last - tick > _DAY // 2
            last = tick
        going_on.append(None if tick is None else tick + days * _DAY)
    return going_on


def _ticks(found: re.Match[str]) -> int:
    parts = found.groupdict()
    whole = _hour(parts) * 3600 + int(parts["m"]) * 60 + int(parts["s"])
    if parts.get("Y"):
        whole += date(int(parts["Y"]), int(parts["M"]), int(parts["D"])).toordinal() * 86400
    ticks = whole * _TICKS_PER_S + int((parts["f"] or "").ljust(12, "0"))
    if parts.get("sign") == "-":
        ticks = -ticks
    return ticks + int(parts.get("days") or 0) * _DAY


def _hour(parts: dict[str, str | None]) -> int:
    """Hour from 0 to 23; 12 AM is 0 and 12 PM is 12."""
    hour = int(parts["h"] or 0)
    half = parts.get("half")
    return hour if half is None else hour % 12 + 12 * (half in "Pp")


def _iso(form: re.Pattern[str], text: str) -> str:
    found = form.fullmatch(text)
    assert found is not None  # it was matched before
    p = found.groupdict()
    fraction = f".{p['f']}" if p["f"] else ""
    zone = re.search(r"(?:Z|[+-]\d\d:?\d\d)$", text.strip()[10:])
    clock = f"{_hour(p):02d}:{int(p['m']):02d}:{int(p['s']):02d}{fraction}"
    day = f"{p['Y']}-{int(p['M']):02d}-{int(p['D']):02d}"
    return f"{day}T{clock}{zone.group() if zone else ''}"
