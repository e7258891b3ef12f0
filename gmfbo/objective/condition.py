"""A user's condition on recorded signals, parsed as a formula and never run as code."""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import InputError, did_you_mean

Values = NDArray[np.float64]

FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    "abs": np.abs,
    "sqrt": np.sqrt,
    "sin": np.sin,
    "cos": np.cos,
    "exp": np.exp,
    "log": np.log,
    "sign": np.sign,
    "min": lambda *values: np.minimum.reduce(np.broadcast_arrays(*values)),
    "max": lambda *values: np.maximum.reduce(np.broadcast_arrays(*values)),
}
"""Functions that a condition may call."""

_BINARY: Mapping[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}
_COMPARE: Mapping[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}


@dataclass(frozen=True)
class Condition:
    """A condition that must hold in each row of a recording.

    Attributes
    ----------
    text : str
        As given, such as `abs(position - reference) < 0.5`.
    tree : ast.expr
        Its formula: numbers, signals, `time`, ``+ - * / **``, comparisons, and, or, not, and the
        functions of `FUNCTIONS`.
    """

    text: str
    tree: ast.expr

    @classmethod
    def parse(cls, text: str) -> Self:
        """Read a condition.

        Parameters
        ----------
        text : str
            A formula with at least one comparison.

        Raises
        ------
        InputError
            The text is no formula of signals.
        """
        try:
            tree = ast.parse(text.strip(), mode="eval").body
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            raise InputError(
                f"expression: expected a formula such as 'abs(position - reference) < 0.5', "
                f"got '{text}'"
            ) from None
        if not _is_truth(tree):
            raise InputError(
                f"expression: expected a comparison such as 'abs(velocity) < 3', got '{text}'"
            )
        _check(tree, text)
        return cls(text, tree)

    @property
    def names(self) -> frozenset[str]:
        """Signals in the formula, without `time`."""
        called = {node.func for node in ast.walk(self.tree) if isinstance(node, ast.Call)}
        return frozenset(
            node.id
            for node in ast.walk(self.tree)
            if isinstance(node, ast.Name) and node not in called and node.id != "time"
        )

    def holds(self, time: Values, signals: Mapping[str, Values]) -> NDArray[np.bool_]:
        """Rows in which the condition holds, shape (n,); rows with a blank signal pass.

        Parameters
        ----------
        time : ndarray, shape (n,)
            [s]
        signals : mapping of str to ndarray, shape (n,)
            All of `names`, in SI.
        """
        values = {"time": time, **{name: signals[name] for name in self.names}}
        blank = np.isnan(np.stack([values[name] for name in values])).any(axis=0)
        with np.errstate(all="ignore"):
            truth = np.broadcast_to(np.asarray(_value(self.tree, values), dtype=bool), time.shape)
        return np.asarray(truth | blank)


def _is_truth(node: ast.expr) -> bool:
    if isinstance(node, ast.BoolOp):
        return all(_is_truth(part) for part in node.values)
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        return _is_truth(node.operand)
    return isinstance(node, ast.Compare)


def _check(node: ast.expr, text: str) -> None:
    """Raise for anything but a formula, before it is evaluated."""
    parts = _parts(node, text)
    for part in parts:
        _check(part, text)


def _parts(node: ast.expr, text: str) -> list[ast.expr]:
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        return []
    if isinstance(node, ast.Name):
        return []
    if isinstance(node, ast.BoolOp):
        return node.values
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not | ast.USub | ast.UAdd):
        return [node.operand]
    if isinstance(node, ast.BinOp) and type(node.op) in _BINARY:
        return [node.left, node.right]
    if isinstance(node, ast.Compare) and all(type(op) in _COMPARE for op in node.ops):
        return [node.left, *node.comparators]
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.keywords:
        if node.func.id not in FUNCTIONS:
            raise InputError(
                f"expression '{text}': no function '{node.func.id}'"
                + did_you_mean(node.func.id, FUNCTIONS)
            )
        many = node.func.id in ("min", "max")
        if (len(node.args) < 2) if many else (len(node.args) != 1):
            wanted = "at least two values" if many else "one value"
            raise InputError(f"expression '{text}': {node.func.id} takes {wanted}")
        return node.args
    raise InputError(
        f"expression '{text}': '{ast.unparse(node)}' is not understood; expected numbers, signals, "
        f"time, + - * / **, comparisons, and, or, not, and {', '.join(FUNCTIONS)}"
    )


def _value(node: ast.expr, values: Mapping[str, Values]) -> Any:
    match node:
        case ast.Constant(value=int() | float() as number):
            return float(number)
        case ast.Name(id=name):
            return values[name]
        case ast.BoolOp(op=op, values=parts):
            both = np.logical_and if isinstance(op, ast.And) else np.logical_or
            truths = [_value(part, values) for part in parts]
            return both.reduce(np.broadcast_arrays(*truths))
        case ast.UnaryOp(op=op, operand=operand):
            inner = _value(operand, values)
            if isinstance(op, ast.Not):
                return np.logical_not(inner)
            return -inner if isinstance(op, ast.USub) else inner
        case ast.BinOp(left=left, op=op, right=right):
            # NumPy's division and power give inf or NaN where Python's numbers would raise.
            return _BINARY[type(op)](np.float64(1.0) * _value(left, values), _value(right, values))
        case ast.Call(func=ast.Name(id=name), args=args):
            return FUNCTIONS[name](*(_value(argument, values) for argument in args))
        case ast.Compare(left=left, ops=ops, comparators=others):
            sides = [_value(side, values) for side in (left, *others)]
            truths = [
                _COMPARE[type(op)](one, other)
                for op, one, other in zip(ops, sides, sides[1:], strict=False)
            ]
            return np.logical_and.reduce(np.broadcast_arrays(*truths))
        case _:
            raise InputError(f"expression: '{ast.unparse(node)}' is not understood")
