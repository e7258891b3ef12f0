"""What a corrected twin has learned, as sentences from the log of its version."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gmfbo.plain_words import interval, number, percent, probability


def learned_lines(details: Mapping[str, Any]) -> tuple[str, ...]:
    """Parameters from -> to with their interval, changed tables, and physics with probability.

    Parameters
    ----------
    details : mapping of str to object
        Logged with a version of the twin, `twin_version` in `events.jsonl`. `learned` lists values
        by `name`, `unit`, `before` (None where the twin had none), `after`, `low`, `high`; `tables`
        by `name` and `change`, the RMS change of the nodes over the table's range; `named` physics
        by `statement` and `probability`. Versions of former studies hold none of them.
    """
    lines = [_value(one) for one in details.get("learned", ())]
    lines += [
        f"table {one['name']}: its nodes moved by {percent(one['change'])} of its range (RMS)"
        for one in details.get("tables", ())
    ]
    lines += [
        f"{one['statement']} (probability {probability(one['probability'])})"
        for one in details.get("named", ())
    ]
    return tuple(lines)


def _value(one: Mapping[str, Any]) -> str:
    before = "" if one["before"] is None else f"{number(one['before'])} -> "
    return f"{one['name']}: {before}{interval(one['after'], one['low'], one['high'], one['unit'])}"
