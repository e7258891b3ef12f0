"""Hash of all content that decides the outcome of a twin's runs."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any

from gmfbo.sources.binding.binding import Binding


def content_hash(binding: Binding, parameters: Mapping[str, float | str], step: float) -> str:
    """SHA-256 of a twin's content; comments, paths and the name do not count.

    Parameters
    ----------
    binding : Binding
        The twin.
    parameters : mapping of str to float or str
        Parameters that override the twin file's.
    step : float
        [s] Communication step in force.
    """
    # Neither a logger's column names nor the list of uncertain parameters changes a run.
    apart = {"name", "fmu", "fmus", "step", "columns", "dialect", "tables", "fixed", "limits"}
    apart |= {"time_limit", "origin"}
    each: dict[str, Any] = {key: {"__all__": {"wrapped"}} for key in ("inputs", "outputs")}
    # Of [recording] the clock alone reaches the FMUs.
    each["recording"] = True if binding.file.recording.clock == "own" else {"resample"}
    file = binding.file.model_dump(mode="json", exclude={**dict.fromkeys(apart, True), **each})
    # Twins of former versions keep their hash.
    file = {k: v for k, v in file.items() if k not in ("words", "stop_time") or v}
    meaning = {
        "file": file,
        "fmus": list(zip(binding.file.fmus or [""], binding.content, strict=True)),
        "preset": dict(binding.preset),
        "parameters": {
            name: value if isinstance(value, str) else float(value)
            for name, value in parameters.items()
        },
        "step": step,
    }
    text = json.dumps(meaning, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()
