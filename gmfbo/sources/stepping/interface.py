"""Names of a FMI version's calls for values, and the C types of these values."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from gmfbo.sources.fmu_file.job import ValueType

Values = Any
"""A ctypes array of one of the types of an interface."""


@dataclass(frozen=True)
class Interface:
    """One version of FMI.

    Attributes
    ----------
    major : int
        2 or 3.
    words : mapping of ValueType to str
        Ending of the calls of each type that the version has.
    c_types : mapping of ValueType to type
        C type of the calls' values.
    """

    major: int
    words: Mapping[ValueType, str]
    c_types: Mapping[ValueType, Any]

    @property
    def do_step(self) -> str:
        """Name of the call that makes a step."""
        return f"fmi{self.major}DoStep"

    def setter(self, kind: ValueType) -> str:
        """Name of the call that sets values of a type."""
        return f"fmi{self.major}Set{self.words[kind]}"

    def getter(self, kind: ValueType) -> str:
        """Name of the call that reads values of a type."""
        return f"fmi{self.major}Get{self.words[kind]}"

    def room(self, kind: ValueType, count: int) -> Values:
        """Array for values of a type."""
        return (self.c_types[kind] * count)()


FMI2 = Interface(
    major=2,
    words={
        ValueType.REAL: "Real",
        ValueType.INTEGER: "Integer",
        ValueType.BOOLEAN: "Boolean",
    },
    c_types={
        ValueType.REAL: ctypes.c_double,
        ValueType.INTEGER: ctypes.c_int,
        ValueType.BOOLEAN: ctypes.c_int,
    },
)
FMI3 = Interface(
    major=3,
    words={
        ValueType.REAL: "Float64",
        ValueType.INTEGER: "Int32",
        ValueType.BOOLEAN: "Boolean",
        ValueType.FLOAT32: "Float32",
        ValueType.INT8: "Int8",
        ValueType.UINT8: "UInt8",
        ValueType.INT16: "Int16",
        ValueType.UINT16: "UInt16",
        ValueType.UINT32: "UInt32",
        ValueType.INT64: "Int64",
        ValueType.UINT64: "UInt64",
    },
    c_types={
        ValueType.REAL: ctypes.c_double,
        ValueType.INTEGER: ctypes.c_int32,
        ValueType.BOOLEAN: ctypes.c_bool,
        ValueType.FLOAT32: ctypes.c_float,
        ValueType.INT8: ctypes.c_int8,
        ValueType.UINT8: ctypes.c_uint8,
        ValueType.INT16: ctypes.c_int16,
        ValueType.UINT16: ctypes.c_uint16,
        ValueType.UINT32: ctypes.c_uint32,
        ValueType.INT64: ctypes.c_int64,
        ValueType.UINT64: ctypes.c_uint64,
    },
)


def crossing(value: float, kind: ValueType) -> float | int | bool:
    """Convert a value for a call; halves round away from zero, as in C."""
    if kind.is_real:
        return value
    if kind == ValueType.BOOLEAN:
        return value != 0.0
    return int(math.copysign(math.floor(abs(value) + 0.5), value))
