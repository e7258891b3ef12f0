"""The model description of a container: its FMUs' variables under new value references."""

from __future__ import annotations

import copy
import math
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from gmfbo.units import parse_unit

_BASE = ("kg", "m", "s", "A", "K", "rad")
_HEAD = ("author", "version", "copyright", "license", "generationDateAndTime")


@dataclass(frozen=True)
class Part:
    """An FMU of the container whose variables are shown.

    Attributes
    ----------
    prefix : str
        Before the names of its variables, with the dot; empty where there is one FMU.
    xml : Element
        Its model description.
    """

    prefix: str
    xml: ET.Element

    def variables(self) -> list[ET.Element]:
        """Scalar variables in the order of the file."""
        return self.xml.findall("ModelVariables/ScalarVariable")

    def name(self, variable: ET.Element) -> str:
        """Name of a variable in the container."""
        return self.prefix + variable.get("name", "")


@dataclass(frozen=True)
class ExposedParameter:
    """A parameter of the container that its FMUs do not show.

    Attributes
    ----------
    name, unit, description : str
        As the container declares them.
    value : float
        [unit] Start value.
    """

    name: str
    unit: str
    description: str
    value: float


@dataclass(frozen=True)
class Heading:
    """Model name and step of the container.

    Attributes
    ----------
    name, identifier, description : str
        Of the model.
    step : float
        [s] Communication step.
    start : float
        [s] Start time of the twin's FMUs.
    """

    name: str
    identifier: str
    description: str
    step: float
    start: float = 0.0


def describe_container(
    heading: Heading,
    parts: Sequence[Part],
    added: Sequence[ExposedParameter],
    references: Mapping[str, int],
    starts: Mapping[str, str],
) -> ET.Element:
    """Write the model description; variables keep all attributes of their FMUs.

    Parameters
    ----------
    heading : Heading
        Model name and step.
    parts : sequence of Part
        FMUs whose variables are shown; those without a reference are left out.
    added : sequence of ExposedParameter
        Further parameters.
    references : mapping of str to int
        Value references by name.
    starts : mapping of str to str
        Start values that differ from the FMUs' own, as the file writes them.
    """
    root = ET.Element("fmiModelDescription", _attributes(heading, parts))
    ET.SubElement(root, "CoSimulation", _capabilities(heading, parts))
    units = _merge_units(part.xml for part in parts)
    for parameter in added:
        if parameter.unit:
            units.setdefault(parameter.unit, _unit_definition(parameter.unit))
    _section(root, "UnitDefinitions", units.values())
    _section(root, "TypeDefinitions", _types(parts))
    root.append(_experiment(heading, parts))
    variables = ET.SubElement(root, "ModelVariables")
    for part in parts:
        for original in part.variables():
            if part.name(original) in references:
                variables.append(_variable(part, original, references, starts))
    for parameter in added:
        variables.append(_parameter(parameter, references))
    root.append(_structure(variables))
    ET.indent(root)
    return root


def _attributes(heading: Heading, parts: Sequence[Part]) -> dict[str, str]:
    attributes = {
        "fmiVersion": "2.0",
        "modelName": heading.name,
        "guid": "",
        "description": heading.description,
        "generationTool": "gmfbo",
        "variableNamingConvention": "structured"
        if all(part.xml.get("variableNamingConvention") == "structured" for part in parts)
        else "flat",
    }
    for name in _HEAD:
        stated = [text for part in parts if (text := part.xml.get(name))]
        # ISO dates sort by time; copyrights of several vendors are all listed.
        if stated:
            several = max(stated) if "Date" in name else "; ".join(dict.fromkeys(stated))
            attributes[name] = several
    return attributes


def _capabilities(heading: Heading, parts: Sequence[Part]) -> dict[str, str]:
    stated = [part.xml.find("CoSimulation") for part in parts]

    def says(flag: str) -> list[bool]:
        return [e is not None and e.get(flag) in ("true", "1") for e in stated]

    # Tools use the stated step: the same as the original's, so that scripts stay unchanged.
    variable = all(says("canHandleVariableCommunicationStepSize"))
    once = any(says("canBeInstantiatedOnlyOncePerProcess"))
    return {
        "modelIdentifier": heading.identifier,
        "canHandleVariableCommunicationStepSize": str(variable).lower(),
        "canBeInstantiatedOnlyOncePerProcess": str(once).lower(),
        "canNotUseMemoryManagementFunctions": "true",
        "canGetAndSetFMUstate": "false",
        "canSerializeFMUstate": "false",
        "providesDirectionalDerivative": "false",
    }


def _section(root: ET.Element, name: str, children: Iterable[ET.Element]) -> None:
    elements = list(children)
    if elements:
        ET.SubElement(root, name).extend(elements)


def _types(parts: Sequence[Part]) -> list[ET.Element]:
    types = []
    for part in parts:
        for original in part.xml.findall("TypeDefinitions/SimpleType"):
            simple = copy.deepcopy(original)
            simple.set("name", part.prefix + simple.get("name", ""))
            types.append(simple)
    return types


def _experiment(heading: Heading, parts: Sequence[Part]) -> ET.Element:
    stated = (part.xml.find("DefaultExperiment") for part in parts)
    first = next((element for element in stated if element is not None), None)
    attributes = dict(first.attrib) if first is not None else {}
    if float(attributes.get("startTime", 0.0)) != heading.start:
        attributes["startTime"] = repr(heading.start)
        attributes.pop("stopTime", None)  # of another FMU, and perhaps before that start
    return ET.Element("DefaultExperiment", {**attributes, "stepSize": repr(heading.step)})


def _variable(
    part: Part, original: ET.Element, references: Mapping[str, int], starts: Mapping[str, str]
) -> ET.Element:
    variable = copy.deepcopy(original)
    name = part.name(original)
    variable.set("name", name)
    variable.set("valueReference", str(references[name]))
    variable.attrib.pop("canHandleMultipleSetPerTimeInstant", None)
    value = next(iter(variable))
    # Both belong to model exchange, and count variables of the original.
    for foreign in ("derivative", "reinit"):
        value.attrib.pop(foreign, None)
    if declared := value.get("declaredType"):
        value.set("declaredType", part.prefix + declared)
    if name in starts:
        value.set("start", starts[name])
    return variable


def _parameter(parameter: ExposedParameter, references: Mapping[str, int]) -> ET.Element:
    variable = ET.Element(
        "ScalarVariable",
        {
            "name": parameter.name,
            "valueReference": str(references[parameter.name]),
            "description": parameter.description,
            "causality": "parameter",
            "variability": "tunable",
            "initial": "exact",
        },
    )
    value = ET.SubElement(variable, "Real", {"start": repr(float(parameter.value))})
    if parameter.unit:
        value.set("unit", parameter.unit)
    return variable


def _structure(variables: ET.Element) -> ET.Element:
    """Outputs and initial unknowns (FMI 2.0.2, section 2.2.8).

    Dependencies are left out, so that each output may depend on all inputs: physics adds paths
    that the FMUs do not state.
    """
    structure = ET.Element("ModelStructure")
    outputs, initial = [], []
    for place, variable in enumerate(variables, start=1):
        causality = variable.get("causality")
        constant = variable.get("variability") == "constant"
        if causality == "output":
            outputs.append(place)
        exact = variable.get("initial", "exact" if constant else "calculated") == "exact"
        if causality == "calculatedParameter" or (causality == "output" and not exact):
            initial.append(place)
    _unknowns(structure, "Outputs", outputs)
    _unknowns(structure, "InitialUnknowns", initial)
    return structure


def _unknowns(structure: ET.Element, name: str, places: Iterable[int]) -> None:
    _section(structure, name, (ET.Element("Unknown", {"index": str(p)}) for p in places))


def _merge_units(descriptions: Iterable[ET.Element]) -> dict[str, ET.Element]:
    """Gather the units of several FMUs; the first definition of a unit in SI holds."""
    units: dict[str, ET.Element] = {}
    for description in descriptions:
        for unit in description.findall("UnitDefinitions/Unit"):
            name = unit.get("name", "")
            if name not in units:
                units[name] = copy.deepcopy(unit)
                continue
            known = units[name]
            base = unit.find("BaseUnit")
            if base is not None and known.find("BaseUnit") is None:
                known.insert(0, copy.deepcopy(base))
            shown = {display.get("name") for display in known.findall("DisplayUnit")}
            known.extend(
                copy.deepcopy(display)
                for display in unit.findall("DisplayUnit")
                if display.get("name") not in shown
            )
    return units


def contradicting_units(descriptions: Iterable[ET.Element]) -> list[str]:
    """Names of units that two FMUs define differently."""
    meanings: dict[str, set[tuple[tuple[str, float], ...]]] = {}
    for description in descriptions:
        for unit in description.findall("UnitDefinitions/Unit"):
            base = unit.find("BaseUnit")
            if base is not None:
                values = {**{"factor": 1.0}, **{k: float(v) for k, v in base.attrib.items()}}
                # A missing exponent means 0.
                meaning = tuple(sorted((k, v) for k, v in values.items() if v != 0.0))
                meanings.setdefault(unit.get("name", ""), set()).add(meaning)
    return sorted(name for name, found in meanings.items() if len(found) > 1)


def _unit_definition(name: str) -> ET.Element:
    """Define a unit such as `N.m/(rad/s)`; without base unit where it is not understood."""
    element = ET.Element("Unit", {"name": name})
    known = parse_unit(name)
    if known is None or known.needs_scale:
        return element
    kg, m, s, a, k, rad, _ = known.dimension
    powers = zip(_BASE, (kg, m, s, a, k, rad), strict=True)
    base = ET.SubElement(element, "BaseUnit", {n: str(power) for n, power in powers if power})
    factor = float(known.factor) * math.pi**known.pi
    if factor != 1.0:
        base.set("factor", repr(factor))
    if known.zero:
        base.set("offset", repr(known.zero))
    return element
