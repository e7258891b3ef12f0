"""Inspect an unknown FMU without running any of its code."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from gmfbo.errors import FmuFileError, in_short
from gmfbo.sources.fmu_file.description import FmuDescription, read_description
from gmfbo.sources.fmu_file.fmu_variable import FmuVariable
from gmfbo.sources.fmu_file.unpacking import open_archive
from gmfbo.sources.inspection.fmu_report import FmuReport
from gmfbo.sources.inspection.starting_twin import starting_twin_file

__all__ = ["FmuReport", "FmuVariable", "inspect_fmu", "starting_twin_file"]


def inspect_fmu(path: str | Path) -> FmuReport:
    """Read an FMU's model description, and check it against the standard.

    Parameters
    ----------
    path : str or Path
        The `.fmu` file.

    Raises
    ------
    FmuFileError
        It is missing, not a zip archive, unsafe, or has no readable model description.
    """
    path = Path(path)
    description = read_description(path)
    return FmuReport(
        path=path,
        name=description.model_name,
        description=description.description,
        generation_tool=description.generation_tool,
        fmi_version=description.fmi_version,
        kinds=description.kinds,
        platforms=description.platforms,
        obstacle=_obstacle(description),
        inputs=_of(description, "input"),
        outputs=_of(description, "output"),
        parameters=_of(description, "parameter"),
        local=_of(description, "local"),
        capabilities=description.capabilities,
        default_step=description.default_step,
        findings=_findings(path, list(description.variables)),
    )


def try_fmu(report: FmuReport) -> str:
    """Run the FMU's code for a few steps in the sandbox; returns the outcome in a line.

    Raises
    ------
    FmuFileError
        It cannot run here, or its library cannot be loaded.
    SimulationError
        It does not run.
    """
    from gmfbo.sources.binding.bind import bind
    from gmfbo.sources.inspection.trial_run import take_first_steps
    from gmfbo.sources.twin_file.twin_file import TwinFile

    file = TwinFile.parse(starting_twin_file(report), report.path.name)
    binding = bind(file, report.path.resolve().parent, report.path.name)
    steps = take_first_steps(binding, file.step)
    return f"{steps} steps of {file.step:g} s went well"


def _of(description: FmuDescription, causality: str) -> tuple[FmuVariable, ...]:
    known = description.variables.values()
    # In place of an array of fixed size stand its elements.
    return tuple(v for v in known if v.causality == causality and not v.split)


def _obstacle(description: FmuDescription) -> str:
    try:
        description.library()
    except FmuFileError as error:
        return str(error)
    return ""


# The grammar's parser takes some 5 ms a name, and time and memory that grow with the square of
# its length: a name of a million letters fills any machine.
_MOST_NAMES, _LONGEST_NAME = 300, 300


def _findings(path: Path, variables: Sequence[str]) -> tuple[str, ...]:
    from fmpy.model_description import ValidationError, read_model_description

    names = len(variables) <= _MOST_NAMES and max(map(len, variables), default=0) <= _LONGEST_NAME
    found: list[object] = []
    try:
        read_model_description(
            str(path),
            validate=True,
            validate_variable_names=names,
            validate_model_structure=True,
        )
    except ValidationError as error:
        found += error.problems
    except Exception as error:  # any exception may come out of fmpy's checks
        found.append(error)
    with open_archive(path) as archive:
        slips = [i.orig_filename for i in archive.infolist() if "\\" in i.orig_filename]
    found += [f"the member '{name}' is written with a backslash" for name in slips]
    if not names:
        found.append(
            f"the {len(variables)} names of variables were not held against the grammar, which "
            f"takes at most {_MOST_NAMES} of at most {_LONGEST_NAME} letters"
        )
    return tuple(in_short(finding) for finding in found)
