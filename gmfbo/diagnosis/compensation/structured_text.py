"""A compensation as function blocks in IEC 61131-3 Structured Text (.st)."""

from __future__ import annotations

import textwrap

from gmfbo.diagnosis.compensation.table import Compensation, CompensationTable
from gmfbo.diagnosis.compensation.text import STATE_WORDS, WIDTH, target_words, wrapped_story


def structured_text(compensation: Compensation) -> str:
    """One function block for each target, with the arithmetic of the C functions.

    It keeps to what controllers of all vendors have: LREAL, DINT, ARRAY, IF, WHILE, ABS and two
    conversions. Tables are variables with initial values, since not every vendor has constants
    that are arrays; nothing writes to them.

    Parameters
    ----------
    compensation : Compensation
        Of a diagnosis.

    Returns
    -------
    str
        ASCII, but for what names of files hold.
    """
    blocks = [_function_block(compensation, target) for target in compensation.targets]
    return "\n".join([_comment(wrapped_story(compensation)), *blocks])


def _comment(lines: list[str]) -> str:
    safe = [line.replace("*)", "* )").replace("(*", "( *") for line in lines]
    return "(* " + "\n   ".join(safe) + " *)\n"


def _function_block(compensation: Compensation, target: str) -> str:
    tables = compensation.of(target)
    units = compensation.units
    inputs = dict.fromkeys(state for table in tables for state in table.states)
    lines = [f"FUNCTION_BLOCK {target}_compensation", "VAR_INPUT"]
    for state in inputs:
        lines.append(f"    {state} : LREAL; {_remark(f'[{units[state]}] {STATE_WORDS[state]}')}")
    told = _remark(f"to ADD to the {target_words(compensation, target)}")
    lines += ["END_VAR", "VAR_OUTPUT", f"    total : LREAL; {told}", "END_VAR", "VAR"]
    for count, table in enumerate(tables, start=1):
        lines.append(f"    {_remark(_table_words(table))}")
        lines += [*_array(f"x_{count}", table.x.tolist()), *_array(f"y_{count}", table.y.tolist())]
    lines += ["    place, found : LREAL;", "    low, high, middle : DINT;"]
    if any(table.period for table in tables):
        lines += ["    turns : LREAL;", "    whole : DINT;"]
    if any(table.factor == "direction" for table in tables):
        lines.append("    direction : LREAL;")
    lines += ["END_VAR", "", "total := 0.0;"]
    for count, table in enumerate(tables, start=1):
        lines += ["", _remark(_table_words(table)), *_looked_up(count, table)]
    return "\n".join([*lines, "END_FUNCTION_BLOCK", ""])


def _table_words(table: CompensationTable) -> str:
    return f"{table.effect} [{table.unit_y}] over {table.over} [{table.unit_x}]"


def _remark(text: str) -> str:
    return _comment([text]).rstrip()


def _array(name: str, values: list[float]) -> list[str]:
    numbers = textwrap.fill(
        ", ".join(map(_literal, values)), WIDTH, initial_indent=" " * 8, subsequent_indent=" " * 8
    )
    return [f"    {name} : ARRAY[0..{len(values) - 1}] OF LREAL := [", f"{numbers}];"]


def _literal(value: float) -> str:
    """All digits of a number; IEC 61131-3 wants a point before the exponent."""
    digits, mark, exponent = repr(float(value)).partition("e")
    if "." not in digits:
        digits += ".0"
    return f"{digits}E{exponent}" if mark else digits


def _looked_up(count: int, table: CompensationTable) -> list[str]:
    x, y = f"x_{count}", f"y_{count}"
    lines = [f"place := {table.over};"]
    if table.period:
        # The conversion rounds on some controllers and cuts off on others: both end below.
        lines += [
            f"turns := place / {_literal(table.period)};",
            "whole := LREAL_TO_DINT(turns);",
            "IF turns < DINT_TO_LREAL(whole) THEN",
            "    whole := whole - 1;",
            "END_IF;",
            f"place := place - {_literal(table.period)} * DINT_TO_LREAL(whole);",
        ]
    lines += [
        "low := 0;",
        f"high := {table.x.size - 1};",
        "WHILE high - low > 1 DO",
        "    middle := (low + high) / 2;",
        f"    IF place < {x}[middle] THEN",
        "        high := middle;",
        "    ELSE",
        "        low := middle;",
        "    END_IF;",
        "END_WHILE;",
        f"IF place <= {x}[low] THEN",
        f"    found := {y}[low];",
        f"ELSIF place >= {x}[high] THEN",
        f"    found := {y}[high];",
        "ELSE",
        f"    found := {y}[low] + ({y}[high] - {y}[low]) / ({x}[high] - {x}[low])"
        f" * (place - {x}[low]);",
        "END_IF;",
    ]
    return [*lines, *_factor(table), "total := total + found;"]


def _factor(table: CompensationTable) -> list[str]:
    if table.factor == "direction":
        return [
            f"direction := velocity / {_literal(table.rest)};",
            "IF direction > 1.0 THEN",
            "    direction := 1.0;",
            "ELSIF direction < -1.0 THEN",
            "    direction := -1.0;",
            "END_IF;",
            "found := found * direction;",
        ]
    if table.factor == "load":
        return ["found := found * ABS(load);"]
    return ["found := found * current;"] if table.factor == "current" else []
