"""Diagnoses one case in a process of its own, and prints what was said as one line of JSON."""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

KEPT = (
    *("schema", "verdict", "evidence", "statement_probability", "effects", "parameters"),
    *("alignment", "location", "fit", "remainder", "shape", "cost", "versions"),
)
"""Of diagnosis.json: all that a recount may ask for."""

LEFT_OUT = {
    "effects": ("evidence_per_recording", "equation"),
    "shape": ("x", "y", "y_low", "y_high"),
}
"""Of these entries, what takes room and no score needs."""


def kept(diagnosis: Mapping[str, Any]) -> dict[str, Any]:
    """Content of diagnosis.json that goes into the line of a case.

    Parameters
    ----------
    diagnosis : mapping
        Of schema 1 or 2.
    """
    content = {key: diagnosis[key] for key in KEPT if key in diagnosis}
    for key, left_out in LEFT_OUT.items():
        entry = content.get(key)
        if isinstance(entry, list):
            content[key] = [_without(one, left_out) for one in entry]
        elif isinstance(entry, Mapping):
            content[key] = _without(entry, left_out)
    return content


def _without(entry: Mapping[str, Any], keys: tuple[str, ...]) -> dict[str, Any]:
    return {key: value for key, value in entry.items() if key not in keys}


def main() -> None:
    """Command line: python -m tests.blind.draw.one FOLDER --engine MODULE:FUNCTION."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").strip())
    parser.add_argument("folder", type=Path)
    parser.add_argument("--engine", default="gmfbo:diagnose")
    given = parser.parse_args()
    module, function = given.engine.split(":")
    diagnose = getattr(import_module(module), function)
    recordings = sorted(given.folder.glob("rec*.csv"))
    diagnosis = diagnose(given.folder / "twin.toml", recordings, jobs=1)
    said = {
        "diagnosis": kept(json.loads(diagnosis.to_json())),
        "cpu_seconds": round(cpu_seconds(), 2),
    }
    sys.stdout.write("\n" + json.dumps(said) + "\n")


def cpu_seconds() -> float:
    """[s] Of this process and those it started and ended: other work does not change it."""
    used = os.times()
    return used.user + used.system + used.children_user + used.children_system


if __name__ == "__main__":
    main()
