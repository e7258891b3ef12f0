"""What decides the outcome of a twin's runs, as one hash."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping

from gmfbo.sources.binding.binding import Binding


def content_hash(binding: Binding, parameters: Mapping[str, float], step: float) -> str:
    """SHA-256 of a twin's meaning: comments, paths and the name do not count.

    Parameters
    ----------
    binding : Binding
        The twin.
    parameters : mapping of str to float
        Given over the twin file's.
    step : float
        [s] Communication step in force.
    """
    # How a logger names its columns changes no run, and neither does what may be estimated.
    apart = {"name", "fmu", "fmus", "step", "columns", "dialect", "tables"}
    file = binding.file.model_dump(mode="json", exclude=apart)
    meaning = {
        "file": file,
        "fmus": list(zip(binding.file.fmus or [""], binding.content, strict=True)),
        "preset": dict(binding.preset),
        "parameters": {name: float(value) for name, value in parameters.items()},
        "step": step,
    }
    text = json.dumps(meaning, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()
