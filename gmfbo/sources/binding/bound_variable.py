"""A variable of one of a twin's FMUs, by the name that the twin file gives it."""

from __future__ import annotations

from dataclasses import dataclass

from gmfbo.errors import InputError
from gmfbo.sources.fmu_file.fmu_variable import FmuVariable
from gmfbo.sources.fmu_file.job import Port, Setting, TextSetting, ValueType, Wire


@dataclass(frozen=True)
class BoundVariable:
    """A variable of one of the twin's FMUs.

    Attributes
    ----------
    name : str
        As the twin file writes it, with the FMU's prefix where there are several.
    fmu : int
        Place of the FMU in the order of computation.
    variable : FmuVariable
        The variable in the FMU's model description.
    """

    name: str
    fmu: int
    variable: FmuVariable

    def port(self, column: int) -> Port:
        """Join the variable to a column of an array."""
        return Port(self.fmu, self.variable.reference, self._type, column)

    def setting(self, value: float) -> Setting:
        """Setting of a value [FMU's unit] before initialisation."""
        return Setting(self.fmu, self.variable.reference, self._type, value)

    def text_setting(self, value: str) -> TextSetting:
        """Setting of a text before initialisation."""
        return TextSetting(self.fmu, self.variable.reference, value)

    @property
    def items_told(self) -> str:
        """Items of an enumeration for a message: Position=1, Velocity=2."""
        return ", ".join(f"{name}={value}" for name, value in self.variable.items)

    def wire_from(self, source: BoundVariable) -> Wire:
        """Drive this input by an output."""
        return Wire(
            *(self.fmu, self.variable.reference, self._type),
            *(source.fmu, source.variable.reference, source._type),
        )

    def check_value(self, value: float) -> None:
        """Refuse a value that the FMU's bounds exclude.

        Parameters
        ----------
        value : float
            [FMU's unit]

        Raises
        ------
        InputError
            The message names variable, bounds and value.
        """
        low, high = self.variable.minimum, self.variable.maximum
        below = low is not None and value < low
        above = high is not None and value > high
        if below or above or value != value or value in (float("inf"), float("-inf")):
            shown = [f"{low:g}" if low is not None else "-inf"]
            shown.append(f"{high:g}" if high is not None else "inf")
            unit = f" {self.variable.unit}" if self.variable.unit else ""
            raise InputError(
                f"parameter '{self.name}': expected a value within [{', '.join(shown)}]{unit}, "
                f"the FMU's bounds, got {value:g}"
            )
        if self.variable.items and value not in {number for _, number in self.variable.items}:
            raise InputError(
                f"parameter '{self.name}': expected one of {self.items_told}, got {value:g}"
            )
        if not ValueType(self._type).is_real and value != round(value):
            raise InputError(
                f"parameter '{self.name}': expected a whole number, it is of type "
                f"{self.variable.type}, got {value:g}"
            )

    @property
    def _type(self) -> int:
        value_type = self.variable.value_type
        assert value_type is not None, "texts are refused when the file is bound"
        return int(value_type)
