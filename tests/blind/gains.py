"""What the oracle's gain of a case asks of a diagnosis, and names under which laws are compared."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tests.blind.hidden import FRICTION

OWED = 60.0
"""Oracle gain above which the name is owed."""


def family(name: str) -> str:
    """Name under which an effect is compared."""
    return "friction" if name in FRICTION else name


def case_gain(answer: Mapping[str, Any]) -> float:
    """Oracle gain of a case; of a pair, what the smaller effect adds to the other."""
    if answer["kind"] == "pair":
        return min(float(e.get("added_gain", answer["oracle_gain"])) for e in answer["effects"])
    return float(answer["oracle_gain"])
