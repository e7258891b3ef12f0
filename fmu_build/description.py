"""modelDescription.xml of a declaration (FMI 2.0.2, section 2.2)."""

from __future__ import annotations

import math
from xml.etree import ElementTree as ET

from fmu_build.declaration import Declaration, Variable
from fmu_build.units import BASE_UNITS, parse_unit

LOG_CATEGORIES = (
    "logEvents",
    "logStatusWarning",
    "logStatusDiscard",
    "logStatusError",
    "logStatusFatal",
)
_CAPABILITIES = {
    "canHandleVariableCommunicationStepSize": "true",
    "canBeInstantiatedOnlyOncePerProcess": "false",
    "canNotUseMemoryManagementFunctions": "true",
    "canGetAndSetFMUstate": "true",
    "canSerializeFMUstate": "true",
}


def model_description(declaration: Declaration, guid: str) -> bytes:
    """XML text with variables in the order of the declaration, so that index = value reference."""
    root = new_description(declaration, {"fmiVersion": "2.0"}, {"guid": guid})
    _add_kind(root, declaration)
    add_units(root, declaration)
    add_experiment(root, declaration)
    variables = ET.SubElement(root, "ModelVariables")
    for reference, variable in enumerate(declaration.variables):
        _add_variable(variables, reference, variable)
    _add_structure(root, declaration)
    ET.indent(root)
    text: bytes = ET.tostring(root, encoding="utf-8", xml_declaration=True)
    return text + b"\n"


def new_description(
    declaration: Declaration, version: dict[str, str], token: dict[str, str]
) -> ET.Element:
    """Root element, whose attributes FMI 2.0 and 3.0 write alike but for two."""
    name = {"modelName": declaration.name}
    return ET.Element(
        "fmiModelDescription",
        version | name | token,
        description=declaration.description,
        license="MIT",
        generationTool="gmfbo",
        variableNamingConvention="structured",
    )


def add_experiment(root: ET.Element, declaration: Declaration) -> None:
    """Add log categories and default experiment, which FMI 2.0 and 3.0 write alike."""
    categories = ET.SubElement(root, "LogCategories")
    for name in LOG_CATEGORIES:
        ET.SubElement(categories, "Category", name=name)
    ET.SubElement(
        root,
        "DefaultExperiment",
        startTime="0",
        stopTime=number(declaration.stop_time),
        stepSize=number(declaration.communication_step),
    )


def _add_kind(root: ET.Element, declaration: Declaration) -> None:
    if declaration.kind == "model_exchange":
        ET.SubElement(root, "ModelExchange", modelIdentifier=declaration.name)
    else:
        attributes = {"modelIdentifier": declaration.name, **_CAPABILITIES}
        ET.SubElement(root, "CoSimulation", attributes)


def add_units(root: ET.Element, declaration: Declaration) -> None:
    """Add the unit definitions, which FMI 2.0 and 3.0 write alike."""
    names = sorted({variable.unit for variable in declaration.variables if variable.unit})
    if not names:
        return
    definitions = ET.SubElement(root, "UnitDefinitions")
    for name in names:
        unit = parse_unit(name)
        element = ET.SubElement(definitions, "Unit", name=name)
        powers = zip(BASE_UNITS, unit.powers, strict=True)
        attributes = {base: str(power) for base, power in powers if power}
        if unit.factor != 1.0:
            attributes["factor"] = number(unit.factor)
        ET.SubElement(element, "BaseUnit", attributes)


def _add_variable(variables: ET.Element, reference: int, variable: Variable) -> None:
    attributes = {
        "name": variable.name,
        "valueReference": str(reference),
        "description": variable.description,
        "causality": variable.causality,
        "variability": variability(variable),
        **initial(variable),
    }
    element = ET.SubElement(variables, "ScalarVariable", attributes)
    kind: dict[str, str] = {}
    if variable.unit and variable.type == "Real":
        kind["unit"] = variable.unit
    kind |= bounds_and_start(variable)
    ET.SubElement(element, variable.type, kind)


def initial(variable: Variable) -> dict[str, str]:
    """Attribute that says how a variable begins; none where the standard's default is meant."""
    if variable.causality == "parameter":
        return {"initial": "exact"}
    return {} if variable.has_start else {"initial": "calculated"}


def bounds_and_start(variable: Variable) -> dict[str, str]:
    """Attributes of the type that a declaration gives."""
    attributes: dict[str, str] = {}
    if variable.type != "Boolean":
        bounds = {"min": variable.low, "max": variable.high}
        attributes |= {
            key: _value(variable, bound) for key, bound in bounds.items() if math.isfinite(bound)
        }
    if variable.has_start:
        attributes["start"] = _value(variable, variable.start)
    return attributes


def variability(variable: Variable) -> str:
    """When a variable may change."""
    if variable.causality == "parameter":
        return "tunable" if variable.tunable else "fixed"
    return "continuous" if variable.type == "Real" else "discrete"


def _value(variable: Variable, value: float) -> str:
    if variable.type == "Boolean":
        return "true" if value else "false"
    return str(int(value)) if variable.type == "Integer" else number(value)


def number(value: float) -> str:
    """Shortest text that reads back as the same number."""
    return repr(float(value))


def _add_structure(root: ET.Element, declaration: Declaration) -> None:
    structure = ET.SubElement(root, "ModelStructure")
    outputs = [
        str(index)
        for index, variable in enumerate(declaration.variables, start=1)
        if variable.causality == "output"
    ]
    for group in ("Outputs", "InitialUnknowns"):
        if outputs:
            element = ET.SubElement(structure, group)
            for index in outputs:
                ET.SubElement(element, "Unknown", index=index)
