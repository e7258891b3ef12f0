"""modelDescription.xml of a declaration (FMI 3.0.1, section 2.4)."""

from __future__ import annotations

from xml.etree import ElementTree as ET

from fmu_build.declaration import Declaration, Variable
from fmu_build.description import (
    add_experiment,
    add_units,
    bounds_and_start,
    initial,
    new_description,
    variability,
)

_TYPES = {"Real": "Float64", "Integer": "Int32", "Boolean": "Boolean"}
_CAPABILITIES = {
    "canHandleVariableCommunicationStepSize": "true",
    "canBeInstantiatedOnlyOncePerProcess": "false",
    "canGetAndSetFMUState": "true",
    "canSerializeFMUState": "true",
}


def model_description3(declaration: Declaration, token: str) -> bytes:
    """XML text with value references as in FMI 2.0; the one after the last is that of the time."""
    root = new_description(declaration, {"fmiVersion": "3.0"}, {"instantiationToken": token})
    ET.SubElement(root, "CoSimulation", {"modelIdentifier": declaration.name, **_CAPABILITIES})
    add_units(root, declaration)
    add_experiment(root, declaration)
    variables = ET.SubElement(root, "ModelVariables")
    for reference, variable in enumerate(declaration.variables):
        _add_variable(variables, reference, variable)
    ET.SubElement(
        variables,
        "Float64",
        name="time",
        valueReference=str(len(declaration.variables)),
        description="Time",
        causality="independent",
        variability="continuous",
    )
    structure = ET.SubElement(root, "ModelStructure")
    for element in ("Output", "InitialUnknown"):
        for reference, variable in enumerate(declaration.variables):
            if variable.causality == "output":
                ET.SubElement(structure, element, valueReference=str(reference))
    ET.indent(root)
    text: bytes = ET.tostring(root, encoding="utf-8", xml_declaration=True)
    return text + b"\n"


def _add_variable(variables: ET.Element, reference: int, variable: Variable) -> None:
    attributes = {
        "name": variable.name,
        "valueReference": str(reference),
        "description": variable.description,
        "causality": variable.causality,
        "variability": variability(variable),
        **initial(variable),
    }
    if variable.unit and variable.type == "Real":
        attributes["unit"] = variable.unit
    attributes |= bounds_and_start(variable)
    ET.SubElement(variables, _TYPES[variable.type], attributes)
