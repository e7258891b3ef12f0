"""Structured Text read by its own grammar, for what a controller would compute.

Written from IEC 61131-3 (third edition), not from the writer: a tokeniser, a parser with types,
and Python made of what was parsed. It knows LREAL, DINT, BOOL, arrays of LREAL, assignment, IF,
WHILE, `ABS`, `LREAL_TO_DINT` and `DINT_TO_LREAL`; anything else is an error. A DINT that overflows
and types that are mixed without a conversion are errors too, as in strict compilers.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

TOKEN = re.compile(
    r"(?P<blank>\s+|\(\*.*?\*\))"
    r"|(?P<real>\d[\d_]*\.\d[\d_]*(?:[eE][+-]?\d+)?)|(?P<range>\.\.)|(?P<whole>\d[\d_]*)"
    r"|(?P<name>[A-Za-z_][A-Za-z0-9_]*)|(?P<sign>:=|<=|>=|<>|[-+*/()\[\],;:<>=])",
    re.DOTALL,
)
_KEYWORDS = (
    "ARRAY AT BY CASE CONSTANT DO ELSE ELSIF END_FOR END_FUNCTION_BLOCK END_IF END_VAR END_WHILE "
    "EXIT FOR FUNCTION_BLOCK IF MOD NOT OF OR AND XOR REPEAT RETURN THEN TO UNTIL VAR VAR_INPUT "
    "VAR_OUTPUT VAR_TEMP WHILE LREAL REAL DINT INT LINT BOOL TRUE FALSE N R S L D P"
)
KEYWORDS = set(_KEYWORDS.split())


class NotStructuredText(Exception):
    """The text breaks the grammar or the rules of types."""


@dataclass
class Block:
    """A function block: its inputs in order, and what it computes from them."""

    name: str
    inputs: list[str] = field(default_factory=list)
    outputs: list[str] = field(default_factory=list)
    types: dict[str, str] = field(default_factory=dict)
    starts: dict[str, Any] = field(default_factory=dict)
    source: str = ""

    def function(self, to_dint: Callable[[float], int] = round) -> Callable[..., float]:
        """One call of a new instance; `to_dint` is the controller's own conversion."""
        names: dict[str, Any] = {"_dint": _dint, "_halves": _halves, "_convert": to_dint}
        body = "".join(f"    {name} = {value!r}\n" for name, value in self.starts.items())
        text = (
            f"def run({', '.join(self.inputs)}):\n{body}{self.source}    return {self.outputs[0]}\n"
        )
        exec(text, names)
        run: Callable[..., float] = names["run"]
        return run


def _dint(value: int) -> int:
    if not -(2**31) <= value < 2**31:
        raise OverflowError(f"a DINT cannot hold {value}")
    return value


def _halves(one: int, other: int) -> int:
    """Division of whole numbers cuts off towards zero."""
    return int(one / other)


def blocks(text: str) -> dict[str, Block]:
    """All function blocks of a file by name."""
    reader = _Reader(list(_tokens(text)))
    found = {}
    while reader.here[0] != "end":
        block = reader.block()
        found[block.name] = block
    return found


def _tokens(text: str) -> Iterator[tuple[str, str]]:
    at = 0
    while at < len(text):
        found = TOKEN.match(text, at)
        if found is None:
            raise NotStructuredText(f"no token at {text[at : at + 30]!r}")
        at = found.end()
        kind = str(found.lastgroup)
        if kind == "name":
            upper = found[0].upper()
            yield ("keyword", upper) if upper in KEYWORDS else ("name", found[0].lower())
        elif kind != "blank":
            yield kind, found[0].replace("_", "")
    yield "end", ""


class _Reader:
    def __init__(self, tokens: list[tuple[str, str]]) -> None:
        self.tokens, self.at, self.made = tokens, 0, Block("")

    @property
    def here(self) -> tuple[str, str]:
        return self.tokens[self.at]

    def take(self, *wanted: str) -> str:
        kind, text = self.here
        if wanted and text not in wanted and kind not in wanted:
            raise NotStructuredText(f"expected {' or '.join(wanted)}, got {kind} {text!r}")
        self.at += 1
        return text

    def block(self) -> Block:
        self.take("FUNCTION_BLOCK")
        self.made = Block(self.take("name"))
        while self.here[1] in ("VAR_INPUT", "VAR_OUTPUT", "VAR", "VAR_TEMP"):
            self._variables(self.take())
        self.made.source = self._statements("    ", "END_FUNCTION_BLOCK")
        self.take("END_FUNCTION_BLOCK")
        return self.made

    # ---- variables

    def _variables(self, section: str) -> None:
        while self.here[1] != "END_VAR":
            names = [self.take("name")]
            while self.here[1] == ",":
                self.take()
                names.append(self.take("name"))
            self.take(":")
            kind, start = self._type()
            self.take(";")
            for name in names:
                if name in self.made.types:
                    raise NotStructuredText(f"{name} is declared twice")
                self.made.types[name] = kind
                if section == "VAR_INPUT":
                    self.made.inputs.append(name)
                    continue
                self.made.starts[name] = start
                self.made.outputs += [name] if section == "VAR_OUTPUT" else []
        self.take("END_VAR")

    def _type(self) -> tuple[str, Any]:
        if self.here[1] != "ARRAY":
            kind = self.take("LREAL", "DINT", "BOOL")
            return kind, 0.0 if kind == "LREAL" else 0
        for wanted in ("ARRAY", "["):
            self.take(wanted)
        first = int(self.take("whole"))
        self.take("range")
        last = int(self.take("whole"))
        for wanted in ("]", "OF", "LREAL", ":=", "["):
            self.take(wanted)
        values = [self._number()]
        while self.here[1] == ",":
            self.take()
            values.append(self._number())
        self.take("]")
        if first or len(values) != last + 1:
            raise NotStructuredText(f"{len(values)} values for ARRAY[{first}..{last}]")
        return "ARRAY", tuple(values)

    def _number(self) -> float:
        sign = -1.0 if self.here[1] == "-" and self.take() else 1.0
        return sign * float(self.take("real"))

    # ---- statements

    def _statements(self, indent: str, *ends: str) -> str:
        lines = ""
        while self.here[1] not in ends:
            lines += self._statement(indent)
        return lines or f"{indent}pass\n"

    def _statement(self, indent: str) -> str:
        if self.here[1] == "IF":
            return self._if(indent)
        if self.here[1] == "WHILE":
            self.take()
            condition = self._of_type("BOOL")
            self.take("DO")
            body = self._statements(indent + "    ", "END_WHILE")
            self.take("END_WHILE")
            self.take(";")
            return f"{indent}while {condition}:\n{body}"
        name = self.take("name")
        kind = self.made.types.get(name)
        if kind is None or name in self.made.inputs or kind == "ARRAY":
            raise NotStructuredText(f"{name} cannot be assigned to")
        self.take(":=")
        value = self._of_type(kind)
        self.take(";")
        return f"{indent}{name} = {f'_dint({value})' if kind == 'DINT' else value}\n"

    def _if(self, indent: str) -> str:
        lines = ""
        while self.here[1] in ("IF", "ELSIF"):
            word = "if" if self.take() == "IF" else "elif"
            condition = self._of_type("BOOL")
            self.take("THEN")
            lines += f"{indent}{word} {condition}:\n"
            lines += self._statements(indent + "    ", "ELSIF", "ELSE", "END_IF")
        if self.here[1] == "ELSE":
            self.take()
            lines += f"{indent}else:\n" + self._statements(indent + "    ", "END_IF")
        self.take("END_IF")
        self.take(";")
        return lines

    # ---- expressions: text in Python and type

    def _of_type(self, wanted: str) -> str:
        text, kind = self._comparison()
        if kind != wanted:
            raise NotStructuredText(f"expected {wanted}, got {kind}: {text}")
        return text

    def _comparison(self) -> tuple[str, str]:
        text, kind = self._sum()
        if self.here[1] not in ("<", ">", "<=", ">=", "=", "<>"):
            return text, kind
        sign = {"=": "==", "<>": "!="}.get(self.here[1], self.here[1])
        self.take()
        return f"({text} {sign} {self._same(kind, self._sum())})", "BOOL"

    def _sum(self) -> tuple[str, str]:
        text, kind = self._product()
        while self.here[1] in ("+", "-"):
            sign = self.take()
            text = f"({text} {sign} {self._same(kind, self._product())})"
        return text, kind

    def _product(self) -> tuple[str, str]:
        text, kind = self._unary()
        while self.here[1] in ("*", "/"):
            sign = self.take()
            other = self._same(kind, self._unary())
            whole = sign == "/" and kind == "DINT"
            text = f"_halves({text}, {other})" if whole else f"({text} {sign} {other})"
        return text, kind

    def _same(self, kind: str, other: tuple[str, str]) -> str:
        if kind not in ("LREAL", "DINT") or other[1] != kind:
            raise NotStructuredText(f"{kind} beside {other[1]}: {other[0]}")
        return other[0]

    def _unary(self) -> tuple[str, str]:
        if self.here[1] == "-":
            self.take()
            text, kind = self._unary()
            return f"(-{text})", kind
        return self._primary()

    def _primary(self) -> tuple[str, str]:
        kind, text = self.here
        if kind in ("real", "whole"):
            self.take()
            return (repr(float(text)), "LREAL") if kind == "real" else (text, "DINT")
        if text == "(":
            self.take()
            inside = self._comparison()
            self.take(")")
            return inside
        name = self.take("name")
        if self.here[1] == "(":
            return self._call(name)
        if self.here[1] == "[" and self.made.types.get(name) == "ARRAY":
            self.take()
            index = self._of_type("DINT")
            self.take("]")
            return f"{name}[{index}]", "LREAL"
        if self.made.types.get(name) not in ("LREAL", "DINT", "BOOL"):
            raise NotStructuredText(f"{name} is not declared")
        return name, self.made.types[name]

    def _call(self, name: str) -> tuple[str, str]:
        known = {
            "abs": ("abs", "LREAL", "LREAL"),
            "lreal_to_dint": ("_convert", "LREAL", "DINT"),
            "dint_to_lreal": ("float", "DINT", "LREAL"),
        }
        if name not in known:
            raise NotStructuredText(f"no function {name}")
        function, wanted, given = known[name]
        self.take("(")
        argument = self._of_type(wanted)
        self.take(")")
        return (
            f"_dint({function}({argument}))" if given == "DINT" else f"{function}({argument})"
        ), given
