"""One variable of an FMU's model description."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from gmfbo.sources.fmu_file.job import ValueType
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
        Of an array; empty for a scalar.
    si : str
        SI unit, by the FMU's definition of the unit; gmfbo's table counts where it is empty.
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
    )


def _value_type(name: str, fmi: int) -> ValueType | None:
    if name == "Enumeration":
        return ValueType.INTEGER if fmi == 2 else ValueType.INT64
    return _VALUE_TYPES.get(name)


def is_parameter(variable: FmuVariable) -> bool:
    """Whether a variable is a parameter and a number."""
    return variable.causality == "parameter" and variable.value_type is not None
