"""A compensation as a table for a drive (.csv) or as C functions (.c)."""

from __future__ import annotations

import textwrap
from itertools import zip_longest

from gmfbo.diagnosis.compensation.table import Compensation, CompensationTable
from gmfbo.plain_words import words
from gmfbo.recordings.csv.header import header_cell
from gmfbo.version import __version__

_WORDS = {"torque": "torque", "command": "actuator command", "reference": "position reference"}
_SIGN = "value to ADD so that the physics that the twin leaves out is cancelled"
WIDTH = 96

STATE_WORDS = {
    "velocity": "of the reference: a feed-forward",
    "position": "of the reference, or measured",
    "acceleration": "of the reference",
    "command": "of the controller, before this is added",
    "current": "of the motor, before this is added, with its sign",
    "load": "amount of load; where it is not measured, the current",
}


def target_words(compensation: Compensation, target: str) -> str:
    """Words for the signal to which a value is added: `torque at the motor shaft [N.m]`.

    Parameters
    ----------
    compensation : Compensation
        Whose units hold.
    target : str
        One of its targets.
    """
    units = compensation.units
    linear = units["position"] == "m"
    said = _WORDS[target]
    if target == "torque":
        said = "force on the axis" if linear else "torque at the motor shaft"
    return f"{said} [{units[target]}]"


def formula(compensation: Compensation, target: str) -> str:
    """Sum of the tables of one target, in words of the header.

    Parameters
    ----------
    compensation : Compensation
        Whose tables.
    target : str
        One of its targets.
    """
    terms = []
    for table in compensation.of(target):
        factor = {"": "", "load": " * abs(load)"}.get(table.factor, f" * {table.factor}")
        terms.append(f"{table.effect}({table.over}){factor}")
    return " + ".join(terms)


def _story(compensation: Compensation) -> list[str]:
    """Lines that a header holds, without the mark of a comment."""
    units = compensation.units
    lines = [f"gmfbo = {__version__}", f"diagnosis = {compensation.diagnosis}", f"sign = {_SIGN}"]
    for target in compensation.targets:
        added = target_words(compensation, target)
        lines.append(f"add to {added} = {formula(compensation, target)}")
    for state in dict.fromkeys(s for table in compensation.tables for s in table.states):
        lines.append(f"{state} [{units[state]}] = {STATE_WORDS[state]}")
    for table in compensation.tables:
        if table.factor == "direction":
            lines.append(f"direction = min(max(velocity / {table.rest!r}, -1), 1)")
        if table.period:
            lines.append(f"period of {table.effect} [{table.unit_x}] = {table.period!r}")
        else:
            lines.append(f"beyond the ends of {table.effect} = the value at the end")
        if table.remark:
            lines.append(f"note on {table.effect} = {table.remark}")
    lines += [f"note = {remark}" for remark in compensation.remarks]
    for entry in compensation.not_compensated:
        lines.append(f"not compensated = {words(entry.effect)}: {entry.advice}")
    return [" ".join(line.split()) for line in dict.fromkeys(lines)]


def wrapped_story(compensation: Compensation) -> list[str]:
    """Lines of the header, wrapped for a comment in code.

    Parameters
    ----------
    compensation : Compensation
        Of a diagnosis.
    """
    return [
        piece
        for line in _story(compensation)
        for piece in textwrap.wrap(line, WIDTH, subsequent_indent="    ")
    ]


def csv_text(compensation: Compensation) -> str:
    """Two columns a table, side by side; between the rows the value follows a straight line."""
    head = [f"# {line}" for line in _story(compensation)]
    tables = compensation.tables
    names: list[str] = []
    for table in tables:
        over = table.over if len(tables) == 1 else f"{table.over} of {table.effect}"
        value = f"{table.effect} per {table.factor}" if _is_rate(table) else table.effect
        names += [header_cell(over, table.unit_x), header_cell(value, table.unit_y)]
    rows = zip_longest(*(column for table in tables for column in (table.x, table.y)))
    cells = [",".join("" if v is None else repr(float(v)) for v in row) for row in rows]
    return "\n".join([*head, ",".join(names), *cells]) + "\n"


def _is_rate(table: CompensationTable) -> bool:
    return table.factor in ("current", "load")


def c_text(compensation: Compensation) -> str:
    """C99 without any header: one function for each target."""
    lines = [line.replace("*/", "* /") for line in wrapped_story(compensation)]
    top = "/* " + "\n * ".join(lines) + " */\n"
    return "\n".join([top, *(_function(compensation, t) for t in compensation.targets)])


def _function(compensation: Compensation, target: str) -> str:
    tables = compensation.of(target)
    states = list(dict.fromkeys(state for table in tables for state in table.states))
    units = compensation.units
    doc = [f"Returns what to ADD to the {target_words(compensation, target)}.", "", "Parameters:"]
    doc += [f"  {state} [{units[state]}] {STATE_WORDS[state]}" for state in states]
    arguments = ", ".join(f"double {state}" for state in states)
    blocks = "".join(_block(table) for table in tables)
    return (
        "/* " + "\n * ".join(doc).replace(" \n", "\n") + " */\n"
        f"double {target}_compensation({arguments})\n{{\n"
        f"    double sum = 0.0;\n{blocks}    return sum;\n}}\n"
    )


def _block(table: CompensationTable) -> str:
    lines = [
        f"    {{ /* {table.effect} [{table.unit_y}] over {table.over} [{table.unit_x}] */",
        _array("x", table.x.tolist()),
        _array("y", table.y.tolist()),
        f"        double at = {table.over}, value;",
    ]
    if table.period:
        lines += [
            f"        double turns = at / {table.period!r};",
            "        long long whole = (long long)turns;",
            "        if (turns < (double)whole) --whole;",
            f"        at -= {table.period!r} * (double)whole;",
        ]
    lines += [
        f"        int low = 0, high = {table.x.size - 1};",
        "        while (high - low > 1) {",
        "            int middle = (low + high) / 2;",
        "            if (at < x[middle]) high = middle; else low = middle;",
        "        }",
        "        if (at <= x[low]) value = y[low];",
        "        else if (at >= x[high]) value = y[high];",
        "        else value = y[low] + (y[high] - y[low]) / (x[high] - x[low]) * (at - x[low]);",
        *_factor(table),
        "        sum += value;",
        "    }",
    ]
    return "\n".join(lines) + "\n"


def _array(name: str, values: list[float]) -> str:
    numbers = textwrap.fill(
        ", ".join(repr(v) for v in values),
        WIDTH,
        initial_indent=" " * 12,
        subsequent_indent=" " * 12,
    )
    return f"        static const double {name}[{len(values)}] = {{\n{numbers}}};"


def _factor(table: CompensationTable) -> list[str]:
    if table.factor == "direction":
        return [
            f"        double direction = velocity / {table.rest!r};",
            "        if (direction > 1.0) direction = 1.0;",
            "        if (direction < -1.0) direction = -1.0;",
            "        value *= direction;",
        ]
    if table.factor == "load":
        return ["        value *= load < 0.0 ? -load : load;"]
    return ["        value *= current;"] if table.factor == "current" else []
