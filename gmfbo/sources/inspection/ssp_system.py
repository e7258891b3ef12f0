"""Read an SSP 1.0 package (System Structure and Parameterization) by fmpy, and flatten it."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any
from urllib.parse import unquote

from gmfbo.errors import FmuFileError, in_short
from gmfbo.sources.fmu_file.numbers import number_from
from gmfbo.sources.fmu_file.unpacking import open_archive, read_member

STRUCTURE = "SystemStructure.ssd"
_KINDS = (None, "", "application/x-fmu-sharedlibrary")

End = tuple[str, str]
"""Component, which is empty for the whole system, and connector."""


@dataclass(frozen=True)
class SspSystem:
    """FMUs of a package and their connections.

    Attributes
    ----------
    name : str
        Of the system.
    fmus : mapping of str to str
        Archive member of each component, in the order of the file.
    wires : mapping of End to End
        Input of a component = output of another.
    inputs : mapping of End to str
        Input of a component = input of the whole system.
    outputs : mapping of str to End
        Output of the whole system = output of a component.
    offered : tuple of End
        Outputs that the components' connectors name.
    parameters : mapping of End to float
        Values that the package sets.
    """

    name: str
    fmus: Mapping[str, str]
    wires: Mapping[End, End]
    inputs: Mapping[End, str]
    outputs: Mapping[str, End]
    offered: tuple[End, ...]
    parameters: Mapping[End, float]


def read_system(path: Path) -> SspSystem:
    """Read the structure of an SSP package; no code of its FMUs runs.

    Parameters
    ----------
    path : Path
        The `.ssp` file.

    Raises
    ------
    FmuFileError
        It is missing, no SSP 1.0 package, or holds something, named in the message, that a twin
        file cannot express.
    """
    with open_archive(path) as archive:
        names = archive.namelist()
        wanted = [name for name in names if name.endswith((".ssd", ".ssv", ".ssm", ".ssb"))]
        texts = {name: read_member(path, archive, name) for name in wanted}
    if STRUCTURE not in texts:
        raise FmuFileError(
            f"'{path.name}' is no SSP package: expected {STRUCTURE} at the top of the archive"
        )
    for name, text in texts.items():
        _refuse_what_fmpy_passes_over(path, name, text)
    flat = _Flat(path)
    flat.add(_parse(path, texts).system, "")
    return flat.system(frozenset(names))


def _parse(path: Path, texts: Mapping[str, bytes]) -> Any:
    from fmpy.ssp.ssd import read_ssd

    # fmpy gets only checked files, and leaves no file open when it fails.
    package = io.BytesIO()
    with zipfile.ZipFile(package, "w") as archive:
        for name, text in texts.items():
            archive.writestr(name, text)
    try:
        return read_ssd(package)
    except Exception as error:
        # fmpy lets exceptions of its XML reader and of its own checks through.
        reason = " ".join(str(error).split()) or type(error).__name__
        raise FmuFileError(
            f"'{path.name}': {STRUCTURE} cannot be read ({reason}); expected SSP 1.0"
        ) from None


def _refuse_what_fmpy_passes_over(path: Path, name: str, text: bytes) -> None:
    """Raise for entities, and for elements that fmpy ignores and that change values."""
    from lxml import etree

    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False)
    try:
        tree = etree.parse(io.BytesIO(text), parser)
    except etree.XMLSyntaxError as error:
        raise FmuFileError(f"'{path.name}': {name} is not valid XML ({error})") from None
    if tree.docinfo.internalDTD is not None:
        raise FmuFileError(
            f"'{path.name}' is refused: {name} declares a document type; expected plain XML"
        )
    for element in tree.iter(tag=etree.Element):
        kind = etree.QName(element).localname
        if kind.endswith("Transformation") or kind in ("SignalDictionaryReference", "MappingEntry"):
            raise FmuFileError(
                f"'{path.name}': {name} has a {kind}: expected connections and parameters that "
                "pass values unchanged; export it without, or write the twin file by hand"
            )


@dataclass
class _Flat:
    """The nested systems of a package as one."""

    path: Path
    fmus: dict[str, str] = field(default_factory=dict)
    kinds: dict[End, str] = field(default_factory=dict)
    into: dict[End, list[End]] = field(default_factory=dict)
    parameters: dict[End, float] = field(default_factory=dict)
    name: str = ""

    def add(self, system: Any, place: str) -> None:
        """Add a system nested at a place, such as `drive` in the whole."""
        self.name = self.name or system.name or self.path.stem
        self._add_connectors(system, place)
        for element in system.elements:
            inner = _inner(place, element.name)
            if hasattr(element, "elements"):
                self.add(element, inner)
                continue
            if element.type not in _KINDS or not str(element.source).lower().endswith(".fmu"):
                raise FmuFileError(
                    f"'{self.path.name}': component '{element.name}' is '{element.source}': "
                    "expected an FMU in the package"
                )
            if inner in self.fmus:
                raise FmuFileError(f"'{self.path.name}': two components are named '{inner}'")
            self.fmus[inner] = unquote(str(element.source)).removeprefix("./")
            self._add_connectors(element, inner)
            for name, value in _parameters(element, self.path):
                self.parameters[inner, name] = value
        for connection in system.connections:
            self._connect(connection, place)
        # Set after the components' values, since an outer system overrides them.
        for name, value in _parameters(system, self.path):
            self.parameters[self._parameter(place, name)] = value

    def _add_connectors(self, element: Any, place: str) -> None:
        for connector in element.connectors:
            self.kinds[place, connector.name] = connector.kind

    def _connect(self, connection: Any, place: str) -> None:
        start, end = (
            (place if element is None else _inner(place, element), connector)
            for element, connector in (
                (connection.startElement, connection.startConnector),
                (connection.endElement, connection.endConnector),
            )
        )
        # The standard lets a connection be written either way round.
        inside = connection.startElement is not None
        if self.kinds.get(start) == ("input" if inside else "output"):
            start, end = end, start
        self.into.setdefault(end, []).append(start)

    def _parameter(self, place: str, name: str) -> End:
        parts = name.split(".")
        for count in range(1, len(parts)):
            component = _inner(place, "_".join(parts[:count]))
            if component in self.fmus:
                return component, ".".join(parts[count:])
        raise FmuFileError(
            f"'{self.path.name}': parameter '{name}': expected COMPONENT.PARAMETER, the components "
            f"are {', '.join(self.fmus)}"
        )

    def system(self, members: frozenset[str]) -> SspSystem:
        """Trace every connection back to the component at which it begins."""
        for name, member in self.fmus.items():
            if member not in members or ".." in PurePosixPath(member).parts:
                raise FmuFileError(
                    f"'{self.path.name}': component '{name}': no FMU '{member}' in the package"
                )
        wires, inputs = {}, {}
        for end in [end for end in self.into if end[0] in self.fmus]:
            source = self._source(end)
            if source[0]:
                wires[end] = source
            else:
                inputs[end] = source[1]
        outputs = {end[1]: self._source(end) for end in self.into if end[0] == ""}
        return SspSystem(
            name=self.name,
            fmus=self.fmus,
            wires=wires,
            inputs=inputs,
            outputs={name: end for name, end in outputs.items() if end[0]},
            offered=tuple(self._offered()),
            parameters=self.parameters,
        )

    def _source(self, end: End) -> End:
        seen = {end}
        while end[0] not in self.fmus or len(seen) == 1:
            before = self.into.get(end, [])
            if len(before) != 1:
                if not end[0] and len(seen) > 1:
                    return end  # an input of the whole
                count = "several connections" if before else "no connection"
                raise FmuFileError(
                    f"'{self.path.name}': expected one connection into '{end[0]}.{end[1]}', "
                    f"there is {count}"
                )
            end = before[0]
            if end in seen:
                raise FmuFileError(f"'{self.path.name}': '{end[1]}' is connected to itself")
            seen.add(end)
        return end

    def _offered(self) -> Iterator[End]:
        for end, kind in self.kinds.items():
            if end[0] in self.fmus and kind == "output":
                yield end


def _inner(place: str, name: str) -> str:
    """Full name of an element: its name after those of the systems around it."""
    plain = str(name).replace(".", "_")
    return f"{place}_{plain}" if place else plain


def _parameters(element: Any, path: Path) -> Iterator[tuple[str, float]]:
    for binding in element.parameterBindings:
        for values in binding.parameterValues:
            for parameter in values.parameters:
                name = f"{binding.prefix or ''}{parameter.name}"
                if parameter.type not in ("Real", "Integer", "Boolean"):
                    raise FmuFileError(
                        f"'{path.name}': parameter '{name}' of '{element.name}' is of type "
                        f"{parameter.type} ({in_short(str(parameter.value), 60)}): expected Real, "
                        "Integer or Boolean; make the value the FMU's own start value, and take "
                        "the parameter out of the package"
                    )
                value = number_from(parameter.value)
                if value is None:
                    raise FmuFileError(
                        f"'{path.name}': parameter '{name}' of '{element.name}': expected a "
                        f"number or truth value, got {in_short(str(parameter.value), 60)!r}; "
                        "correct it in the package"
                    )
                yield name, value
