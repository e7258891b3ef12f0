"""What an FMU says of itself, read without running any of its code."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from gmfbo.errors import FmuFileError
from gmfbo.recordings.units import parse_unit
from gmfbo.sources.job import ValueType
from gmfbo.sources.platforms import Platform, this_platform
from gmfbo.sources.unpacking import member_path, open_archive

if TYPE_CHECKING:
    from fmpy.model_description import ModelDescription, ModelVariable

_VALUE_TYPES = {
    "Real": ValueType.REAL,
    "Integer": ValueType.INTEGER,
    "Enumeration": ValueType.INTEGER,
    "Boolean": ValueType.BOOLEAN,
}
_CAPABILITIES = (
    "canHandleVariableCommunicationStepSize",
    "canInterpolateInputs",
    "maxOutputDerivativeOrder",
    "canBeInstantiatedOnlyOncePerProcess",
    "canGetAndSetFMUstate",
    "canSerializeFMUstate",
    "providesDirectionalDerivative",
    "needsExecutionTool",
)
_SYSTEM_OF = {"linux": "Linux", "win": "Windows", "windows": "Windows", "darwin": "macOS"}


@dataclass(frozen=True)
class FmuVariable:
    """One scalar variable of an FMU.

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

    @property
    def tunable(self) -> bool:
        """A parameter that may change during a run."""
        return self.causality == "parameter" and self.variability == "tunable"

    @property
    def value_type(self) -> ValueType | None:
        """How the value crosses the interface; None for texts."""
        return _VALUE_TYPES.get(self.type)

    @property
    def si_unit(self) -> str:
        """SI unit in gmfbo's spelling; the FMU's own where that is not understood."""
        known = parse_unit(self.unit) if self.unit else None
        return known.si if known and not known.needs_scale else self.unit


@dataclass(frozen=True)
class FmuDescription:
    """The model description of an FMU and what its archive holds.

    Attributes
    ----------
    path : Path
        The `.fmu` file.
    model_name, guid, generation_tool, description : str
        As the file states.
    fmi_version : str
        Such as `2.0`.
    kinds : tuple of str
        Of `co-simulation` and `model exchange`.
    identifier : str
        Model identifier for co-simulation, else for model exchange: stem of the library's name.
    platforms : tuple of str
        Folders below `binaries/` that hold a library.
    libraries : tuple of str
        Members of the archive below `binaries/`.
    capabilities : mapping of str to bool or int
        Flags of co-simulation by their names in the standard.
    variables : mapping of str to FmuVariable
        By name, in the order of the file.
    default_step : float or None
        [s] Step of the default experiment.
    """

    path: Path
    model_name: str
    guid: str
    generation_tool: str
    description: str
    fmi_version: str
    kinds: tuple[str, ...]
    identifier: str
    platforms: tuple[str, ...]
    libraries: tuple[str, ...]
    capabilities: Mapping[str, bool | int]
    variables: Mapping[str, FmuVariable]
    default_step: float | None = None

    def library(self, platform: Platform | None = None) -> str:
        """Archive member with the library for a platform.

        Parameters
        ----------
        platform : Platform, optional
            This machine's unless given.

        Raises
        ------
        FmuFileError
            The FMU cannot run here: it says what it has and what to ask the vendor for.
        """
        here = platform or this_platform()
        if "co-simulation" not in self.kinds:
            raise FmuFileError(
                f"'{self.path.name}' is for model exchange only: expected co-simulation, which "
                "brings its own solver; ask its vendor to export FMI 2.0 co-simulation"
            )
        if self.fmi_version != "2.0":
            raise FmuFileError(
                f"'{self.path.name}' is FMI {self.fmi_version}: expected FMI 2.0; ask its vendor "
                "to export FMI 2.0 co-simulation"
            )
        for folder in here.fmi_folders:
            found = [
                member
                for member in map(PurePosixPath, self.libraries)
                if member.parts[1] == folder and member.suffix == here.suffix
            ]
            # Some exporters name the library other than the identifier that they state.
            named = [member for member in found if member.stem == self.identifier]
            if named or len(found) == 1:
                return str((named or found)[0])
            if found:
                names = ", ".join(sorted(member.name for member in found))
                raise FmuFileError(
                    f"'{self.path.name}': expected binaries/{folder}/{self.identifier}"
                    f"{here.suffix}, found {names}; ask its vendor for a corrected export"
                )
        raise FmuFileError(self._no_binary(here))

    def _no_binary(self, here: Platform) -> str:
        has = ", ".join(self.platforms) if self.platforms else "no binaries at all"
        systems = sorted({_system_of(folder) for folder in self.platforms})
        other = f", or use it on {' or '.join(systems)}" if systems else ""
        return (
            f"'{self.path.name}' has no binary for this machine ({here.name}): expected a library "
            f"in binaries/{here.fmi_folders[0]}, it has {has}; ask its vendor for an FMI 2.0 "
            f"co-simulation export with binaries/{here.fmi_folders[0]}{other}"
        )


def read_description(path: Path) -> FmuDescription:
    """Read the model description of an FMU; no code of the FMU runs.

    Violations of the schema are no reason to refuse: `inspect_fmu` lists them.

    Parameters
    ----------
    path : Path
        The `.fmu` file.

    Raises
    ------
    FmuFileError
        It is missing, not a zip archive, unsafe, or has no readable model description.
    """
    with open_archive(path) as archive:
        names = archive.namelist()
    if "modelDescription.xml" not in names:
        raise FmuFileError(
            f"'{path}' is no FMU: expected a modelDescription.xml at the top of the archive; "
            "export it again"
        )
    raw = _parse(path)
    interface = raw.coSimulation or raw.modelExchange
    if interface is None:
        raise FmuFileError(
            f"'{path.name}' offers neither co-simulation nor model exchange; export it again"
        )
    libraries = tuple(name for name in names if _is_library(member_path(path, name)))
    units = {unit.name: unit.baseUnit for unit in raw.unitDefinitions}
    variables = [_variable(variable, units) for variable in raw.modelVariables]
    return FmuDescription(
        path=path,
        model_name=raw.modelName or path.stem,
        guid=raw.guid or "",
        generation_tool=raw.generationTool or "",
        description=raw.description or "",
        fmi_version=raw.fmiVersion or "",
        kinds=_kinds(raw),
        identifier=interface.modelIdentifier or path.stem,
        platforms=tuple(dict.fromkeys(PurePosixPath(name).parts[1] for name in libraries)),
        libraries=libraries,
        capabilities=MappingProxyType(_capabilities(raw)),
        variables=MappingProxyType({variable.name: variable for variable in variables}),
        default_step=_number(raw.defaultExperiment.stepSize) if raw.defaultExperiment else None,
    )


def _parse(path: Path) -> ModelDescription:
    from fmpy.model_description import read_model_description

    try:
        return read_model_description(str(path), validate=False)
    except Exception as error:
        # fmpy raises whatever its XML reader and its own checks raise.
        reason = " ".join(str(error).split()) or type(error).__name__
        raise FmuFileError(
            f"'{path.name}': modelDescription.xml cannot be read ({reason}); ask its vendor for a "
            "valid FMI 2.0 export"
        ) from None


def _is_library(member: PurePosixPath) -> bool:
    return (
        len(member.parts) == 3
        and member.parts[0] == "binaries"
        and member.suffix in (".so", ".dll", ".dylib")
    )


def _system_of(folder: str) -> str:
    system = folder.rpartition("-")[2].rstrip("0123456789")
    return _SYSTEM_OF.get(system, folder)


def _kinds(raw: ModelDescription) -> tuple[str, ...]:
    kinds = (("co-simulation", raw.coSimulation), ("model exchange", raw.modelExchange))
    return tuple(kind for kind, interface in kinds if interface is not None)


def _capabilities(raw: ModelDescription) -> dict[str, bool | int]:
    interface = raw.coSimulation or raw.modelExchange
    stated = {name: getattr(interface, name, None) for name in _CAPABILITIES}
    return {name: _flag(value) for name, value in stated.items() if value is not None}


def _flag(value: object) -> bool | int:
    if isinstance(value, bool | int):
        return value
    text = str(value)
    return int(text) if text.isdigit() and text not in "01" else text in ("true", "1")


def _variable(raw: ModelVariable, units: Mapping[str, Any]) -> FmuVariable:
    declared = raw.declaredType
    unit = raw.unit or getattr(declared, "unit", None) or ""
    to_si, si_zero = _conversion(unit, units.get(unit))
    minimum = raw.min if raw.min is not None else getattr(declared, "min", None)
    maximum = raw.max if raw.max is not None else getattr(declared, "max", None)
    text = raw.type in ("String", "Binary")
    return FmuVariable(
        name=raw.name,
        reference=int(raw.valueReference),
        type=raw.type,
        causality=raw.causality or "local",
        variability=raw.variability or "continuous",
        unit=unit,
        to_si=to_si,
        si_zero=si_zero,
        start=None if text else _number(raw.start),
        minimum=None if text else _number(minimum),
        maximum=None if text else _number(maximum),
        description=raw.description or "",
    )


def _conversion(unit: str, base: Any) -> tuple[float, float]:
    """Factor and zero of a unit: gmfbo's own table first, since many FMUs state no base unit."""
    known = parse_unit(unit) if unit else None
    if known is not None and not known.needs_scale:
        import numpy as np

        ends = known.to_si(np.array([0.0, 1.0]))
        return float(ends[1] - ends[0]), float(ends[0])
    if base is None:
        return 1.0, 0.0
    factor, zero = _number(base.factor), _number(base.offset)
    return (1.0 if factor is None else factor), (zero or 0.0)


def _number(text: object) -> float | None:
    if text is None:
        return None
    if str(text).strip() in ("true", "false"):
        return 1.0 if str(text).strip() == "true" else 0.0
    try:
        return float(str(text))
    except ValueError:
        return None
