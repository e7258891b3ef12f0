"""One variable of an FMU's model description."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product
from math import prod
from typing import TYPE_CHECKING, Any

from gmfbo.sources.fmu_file.job import LARGEST_SIZE, ArrayElement, ValueType
from gmfbo.sources.fmu_file.numbers import number_from
from gmfbo.sources.fmu_file.unit_definition import fmu_unit
from gmfbo.units import parse_unit

if TYPE_CHECKING:
    from fmpy.model_description import ModelVariable

_VALUE_TYPES = {
    "Real": ValueType.REAL,
    "Integer": ValueType.INTEGER,
    "Boolean": ValueType.BOOLEAN,
    "Float64": ValueType.REAL,
    "Float32": ValueType.FLOAT32,
    "Int8": ValueType.INT8,
    "UInt8": ValueType.UINT8,
    "Int16": ValueType.INT16,
    "UInt16": ValueType.UINT16,
    "Int32": ValueType.INTEGER,
    "UInt32": ValueType.UINT32,
    "Int64": ValueType.INT64,
    "UInt64": ValueType.UINT64,
}


@dataclass(frozen=True)
class FmuVariable:
    """One variable of an FMU.

    Attributes
    ----------
    name : str
        Name in the model description.
    reference : int
        Value reference.
    type : str
        `Real`, `Integer`, `Enumeration`, `Boolean`, `String`, or a type of FMI 3.0.
    causality, variability : str
        As in the standard; the standard's defaults where the file states none.
    unit : str
        As the FMU writes it; empty where it states none.
    to_si, si_zero : float
        Value in SI = value * to_si + si_zero.
    start, minimum, maximum : float or None
        [unit] None where the file states none or the variable is a text.
    description : str
        The vendor's words.
    value_type : ValueType or None
        Type of the value at the FMI interface; None for texts, clocks and arrays, which are no
        single numbers.
    shape : tuple of int
        Of an array; empty for a scalar and for an element, whose `reference` tells its place.
    si : str
        SI unit, by the FMU's definition of the unit; gmfbo's table counts where it is empty.
    split : bool
        Whether the elements of an array are variables of their own.
    items : tuple of (str, int)
        Names and values of an enumeration, in the FMU's order; empty for other types.
    start_text : str
        Start value of a text.
    """

    name: str
    reference: int
    type: str
    causality: str
    variability: str
    unit: str = ""
    to_si: float = 1.0
    si_zero: float = 0.0
    start: float | None = None
    minimum: float | None = None
    maximum: float | None = None
    description: str = ""
    value_type: ValueType | None = None
    shape: tuple[int, ...] = ()
    si: str = ""
    split: bool = False
    items: tuple[tuple[str, int], ...] = ()
    start_text: str = ""

    @property
    def tunable(self) -> bool:
        """Whether it is a parameter that may change during a run."""
        return self.causality == "parameter" and self.variability == "tunable"

    @property
    def si_unit(self) -> str:
        """SI unit in gmfbo's spelling; the FMU's own where that is not understood."""
        if self.si:
            return self.si
        known = parse_unit(self.unit) if self.unit else None
        return known.si if known and not known.needs_scale else self.unit


def variable_from(raw: ModelVariable, units: Mapping[str, Any], fmi: int = 2) -> FmuVariable:
    """Convert a variable from fmpy.

    Parameters
    ----------
    raw : fmpy.model_description.ModelVariable
        As it was read.
    units : mapping of str to fmpy.model_description.BaseUnit or None
        Base units by the names of the FMU's unit definitions.
    fmi : int
        Major version of FMI.
    """
    declared = raw.declaredType
    unit = raw.unit or getattr(declared, "unit", None) or ""
    si = fmu_unit(unit, units.get(unit))
    minimum = raw.min if raw.min is not None else getattr(declared, "min", None)
    maximum = raw.max if raw.max is not None else getattr(declared, "max", None)
    shape = tuple(raw.shape)
    text = raw.type in ("String", "Binary", "Clock") or bool(shape)
    return FmuVariable(
        name=raw.name,
        reference=int(raw.valueReference),
        type=raw.type,
        causality=raw.causality or "local",
        variability=raw.variability or "continuous",
        unit=unit,
        to_si=si.factor,
        si_zero=si.zero,
        si=si.si,
        start=None if text else number_from(raw.start),
        minimum=None if text else number_from(minimum),
        maximum=None if text else number_from(maximum),
        description=raw.description or "",
        value_type=None if shape else _value_type(raw.type, fmi),
        shape=shape,
        items=_items(declared) if raw.type == "Enumeration" else (),
        start_text=_start_text(raw) if raw.type == "String" and not shape else "",
    )


def elements_of(array: FmuVariable, raw: ModelVariable, fmi: int = 3) -> list[FmuVariable]:
    """Elements of an array of fixed size as variables, `q[1]` or `m[1,2]`, row by row.

    Parameters
    ----------
    array : FmuVariable
        From `variable_from`.
    raw : fmpy.model_description.ModelVariable
        The same, as it was read.
    fmi : int
        Major version of FMI.

    Returns
    -------
    list of FmuVariable
        Empty for scalars and texts, and for arrays whose size is a parameter or above
        `LARGEST_SIZE`.
    """
    size = prod(array.shape)
    kind = _value_type(raw.type, fmi)
    fixed = all(d.valueReference is None and d.start is not None for d in raw.dimensions or ())
    if not array.shape or not fixed or kind is None or not 0 < size <= LARGEST_SIZE:
        return []
    texts = str(raw.start).split() if isinstance(raw.start, str) else list(raw.start or ())
    starts = [number_from(text) for text in texts] * (size if len(texts) == 1 else 1)
    indices = product(*(range(1, length + 1) for length in array.shape))
    return [
        replace(
            array,
            name=f"{array.name}[{','.join(map(str, index))}]",
            reference=ArrayElement(array.reference, place, size).packed,
            start=starts[place] if len(starts) == size else None,
            minimum=number_from(raw.min),
            maximum=number_from(raw.max),
            value_type=kind,
            shape=(),
        )
        for place, index in enumerate(indices)
    ]


def _start_text(raw: ModelVariable) -> str:
    start = raw.start
    if isinstance(start, list):  # FMI 3.0 has an element for each text
        start = start[0] if start else ""
    return "" if start is None else str(start)


def _items(declared: Any) -> tuple[tuple[str, int], ...]:
    """Items of an enumeration; FMI 2.0 counts items without a value from 1."""
    items = getattr(declared, "items", None) or ()
    numbers = [number_from(getattr(item, "value", None)) for item in items]
    return tuple(
        (str(item.name), int(k if number is None else number))
        for k, (item, number) in enumerate(zip(items, numbers, strict=True), start=1)
    )


def _value_type(name: str, fmi: int) -> ValueType | None:
    if name == "Enumeration":
        return ValueType.INTEGER if fmi == 2 else ValueType.INT64
    return _VALUE_TYPES.get(name)


def is_parameter(variable: FmuVariable) -> bool:
    """Whether a variable is a parameter and a number."""
    return variable.causality == "parameter" and variable.value_type is not None


def is_text_parameter(variable: FmuVariable) -> bool:
    """Whether a variable is a parameter of type String, and a single one."""
    return variable.causality == "parameter" and variable.type == "String" and not variable.shape
