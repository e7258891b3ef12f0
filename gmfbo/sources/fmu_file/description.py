"""Read an FMU's model description without running any of its code."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from gmfbo.errors import FmuFileError, in_short
from gmfbo.sources.fmu_file.fmu_variable import FmuVariable, elements_of, variable_from
from gmfbo.sources.fmu_file.numbers import number_from
from gmfbo.sources.fmu_file.platforms import Platform, this_platform
from gmfbo.sources.fmu_file.prolog import check_prolog
from gmfbo.sources.fmu_file.unpacking import member_path, open_archive, read_member

if TYPE_CHECKING:
    from fmpy.model_description import ModelDescription, ModelVariable

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
_CAPABILITIES_3 = ("hasEventMode", "canReturnEarlyAfterIntermediateUpdate")
_SYSTEM_OF = {"linux": "Linux", "win": "Windows", "windows": "Windows", "darwin": "macOS"}


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
        Of `co-simulation`, `model exchange` and `scheduled execution`.
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
    default_step, default_start : float or None
        [s] Step and start time of the default experiment.
    with_sources : bool
        Whether C sources lie in it.
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
    default_start: float | None = None
    with_sources: bool = False

    @property
    def major(self) -> int:
        """Major version of FMI; 0 where it is none."""
        return int(self.fmi_version[0]) if self.fmi_version[:1].isdigit() else 0

    def library(self, platform: Platform | None = None) -> str:
        """Archive member with the library for a platform.

        Parameters
        ----------
        platform : Platform, optional
            This machine's unless given.

        Raises
        ------
        FmuFileError
            The FMU cannot run here; the message lists its platforms and what to ask the vendor for.
        """
        here = platform or this_platform()
        self._check_steppable()
        for folder in self._folders(here):
            found = [
                member
                for member in map(PurePosixPath, self.libraries)
                if member.parts[1] == folder and member.suffix == here.suffix
            ]
            # Some exporters' library names differ from the stated identifier.
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

    def _check_steppable(self) -> None:
        """Raise unless the FMU can be stepped from communication point to communication point."""
        ask = f"ask its vendor to export FMI {3 if self.major == 3 else 2}.0 co-simulation"
        if "co-simulation" not in self.kinds:
            own = "brings its own solver"
            if self.kinds == ("scheduled execution",):
                own = "keeps its own time"
            raise FmuFileError(
                f"'{self.path.name}' is for {' and '.join(self.kinds)} only: expected "
                f"co-simulation, which {own}; {ask}"
            )
        if self.major not in (2, 3):
            raise FmuFileError(
                f"'{self.path.name}' is FMI {self.fmi_version}: expected FMI 2.0 or 3.0; {ask}"
            )
        clocks = [name for name, variable in self.variables.items() if variable.type == "Clock"]
        if clocks:
            others = f" and {len(clocks) - 1} more" if len(clocks) > 1 else ""
            raise FmuFileError(
                f"'{self.path.name}' has the clock '{clocks[0]}'{others}: expected an FMU without "
                "clocks, since gmfbo steps at fixed communication points; ask its vendor for an "
                "export that ticks its clocks itself"
            )

    def _folders(self, here: Platform) -> tuple[str, ...]:
        """Folders in which a library for a platform may lie, those of the FMI version first."""
        return here.fmi_folders if self.major == 2 else here.fmi_folders[::-1]

    def _no_binary(self, here: Platform) -> str:
        wanted = self._folders(here)[0]
        has = ", ".join(self.platforms) if self.platforms else "no binaries at all"
        if self.with_sources and not self.platforms:
            has = "C sources only, which gmfbo does not compile"
        systems = sorted({_system_of(folder) for folder in self.platforms})
        other = f", or use it on {' or '.join(systems)}" if systems else ""
        return (
            f"'{self.path.name}' has no binary for this machine ({here.name}): expected a library "
            f"in binaries/{wanted}, it has {has}; ask its vendor for an FMI {self.major}.0 "
            f"co-simulation export with binaries/{wanted}{other}"
        )


def read_description(path: Path) -> FmuDescription:
    """Read the model description of an FMU; no code of the FMU runs.

    Violations of the schema are tolerated; `inspect_fmu` lists them.

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
        described = "modelDescription.xml" in names
        content = read_member(path, archive, "modelDescription.xml") if described else b""
    if not described:
        raise _no_fmu(path, names)
    check_prolog(path.name, content)
    raw = _parse(path)
    interface = raw.coSimulation or raw.modelExchange or raw.scheduledExecution
    if interface is None:
        raise FmuFileError(
            f"'{path.name}' offers neither co-simulation nor model exchange; export it again"
        )
    version = raw.fmiVersion or ""
    # Exporters on Windows were seen to write backslashes; the paths below have slashes.
    members = [member_path(path, name) for name in names]
    libraries = tuple(str(member) for member in members if _is_library(member))
    units = {unit.name: unit.baseUnit for unit in raw.unitDefinitions}
    fmi = 3 if version.startswith("3") else 2
    variables = _with_elements(raw.modelVariables, units, fmi)
    default = raw.defaultExperiment
    return FmuDescription(
        path=path,
        model_name=raw.modelName or path.stem,
        guid=raw.guid or "",
        generation_tool=raw.generationTool or "",
        description=raw.description or "",
        fmi_version=version,
        kinds=_kinds(raw),
        identifier=interface.modelIdentifier or path.stem,
        platforms=tuple(dict.fromkeys(PurePosixPath(name).parts[1] for name in libraries)),
        libraries=libraries,
        capabilities=MappingProxyType(_capabilities(raw)),
        variables=MappingProxyType({variable.name: variable for variable in variables}),
        with_sources=any(m.parts[:1] == ("sources",) and m.suffix == ".c" for m in members),
        default_step=number_from(default.stepSize) if default else None,
        default_start=number_from(default.startTime) if default else None,
    )


def _no_fmu(path: Path, names: Sequence[str]) -> FmuFileError:
    """Error for an archive without a model description, by what else it holds."""
    if "SystemStructure.ssd" in names:
        return FmuFileError(
            f"'{path}' is an SSP package of several FMUs: gmfbo import '{path.name}' --out FOLDER "
            "makes a twin of it"
        )
    return FmuFileError(
        f"'{path}' is no FMU: expected a modelDescription.xml at the top of the archive; "
        "export it again"
    )


def _with_elements(
    raw: Sequence[ModelVariable], units: Mapping[str, Any], fmi: int
) -> list[FmuVariable]:
    """All variables; behind an array of fixed size its elements, as variables of their own."""
    names = {variable.name for variable in raw}
    variables: list[FmuVariable] = []
    for variable in raw:
        read = variable_from(variable, units, fmi)
        elements = elements_of(read, variable, fmi) if read.shape else []
        if any(element.name in names for element in elements):
            elements = []  # the FMU has variables of these names
        variables += [replace(read, split=bool(elements)), *elements]
    return variables


def _parse(path: Path) -> ModelDescription:
    from fmpy.model_description import read_model_description

    try:
        return read_model_description(str(path), validate=False)
    except Exception as error:
        # fmpy lets exceptions of its XML reader and of its own checks through.
        raise FmuFileError(
            f"'{path.name}': modelDescription.xml cannot be read ({in_short(error)}); ask its "
            "vendor for a valid FMI 2.0 export"
        ) from None


def _is_library(member: PurePosixPath) -> bool:
    return (
        len(member.parts) == 3
        and member.parts[0] == "binaries"
        and member.suffix in (".so", ".dll", ".dylib")
    )


def _system_of(folder: str) -> str:
    system = folder.rpartition("-")[2].rstrip("0123456789")
    return ("32-bit " if folder.endswith("32") else "") + _SYSTEM_OF.get(system, folder)


def _kinds(raw: ModelDescription) -> tuple[str, ...]:
    kinds = (
        ("co-simulation", raw.coSimulation),
        ("model exchange", raw.modelExchange),
        ("scheduled execution", raw.scheduledExecution),
    )
    return tuple(kind for kind, interface in kinds if interface is not None)


def _capabilities(raw: ModelDescription) -> dict[str, bool | int]:
    interface = raw.coSimulation or raw.modelExchange or raw.scheduledExecution
    names = _CAPABILITIES + (_CAPABILITIES_3 if (raw.fmiVersion or "").startswith("3") else ())
    stated = {name: getattr(interface, name, None) for name in names}
    return {name: _flag(value) for name, value in stated.items() if value is not None}


def _flag(value: object) -> bool | int:
    if isinstance(value, bool | int):
        return value
    text = str(value)
    return int(text) if text.isdigit() and text not in "01" else text in ("true", "1")
