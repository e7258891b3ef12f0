"""Report on an FMU, as values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from gmfbo.sources.fmu_file.fmu_variable import FmuVariable


@dataclass(frozen=True)
class FmuReport:
    """Report of `gmfbo inspect`.

    Attributes
    ----------
    path : Path
        The file.
    name, description, generation_tool : str
        As the file states.
    fmi_version : str
        Such as `2.0`.
    kinds : tuple of str
        Of `co-simulation` and `model exchange`.
    platforms : tuple of str
        Folders below `binaries/` that hold a library.
    obstacle : str
        Why gmfbo cannot run it on this machine, and the cure; empty where it can.
    inputs, outputs, parameters, local : tuple of FmuVariable
        By causality, in the order of the file.
    capabilities : mapping of str to bool or int
        Flags of co-simulation by their names in the standard.
    default_step : float or None
        [s] Step of the default experiment.
    findings : tuple of str
        Violations of the standard; many FMUs work in spite of them.
    """

    path: Path
    name: str
    description: str
    generation_tool: str
    fmi_version: str
    kinds: tuple[str, ...]
    platforms: tuple[str, ...]
    obstacle: str
    inputs: tuple[FmuVariable, ...]
    outputs: tuple[FmuVariable, ...]
    parameters: tuple[FmuVariable, ...]
    local: tuple[FmuVariable, ...]
    capabilities: Mapping[str, bool | int]
    default_step: float | None
    findings: tuple[str, ...]
