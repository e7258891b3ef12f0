"""Unit definitions of an FMI 2.0 model description."""

from __future__ import annotations

import copy
import math
import xml.etree.ElementTree as ET
from collections.abc import Iterable

from gmfbo.recordings.columns.units import parse_unit

_BASE = ("kg", "m", "s", "A", "K", "rad")


def merge_units(descriptions: Iterable[ET.Element]) -> dict[str, ET.Element]:
    """Gather the units of several FMUs; the first definition in SI counts.

    Parameters
    ----------
    descriptions : iterable of Element
        Model descriptions.

    Returns
    -------
    dict of str to Element
        `Unit` elements by name.
    """
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
    """Names of units that two FMUs define differently.

    Parameters
    ----------
    descriptions : iterable of Element
        Model descriptions.
    """
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


def unit_definition(name: str) -> ET.Element:
    """Define a unit such as `N.m/(rad/s)`; an unknown unit gets no base unit.

    Parameters
    ----------
    name : str
        As it stands at the variable.
    """
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
