"""The augmented twin as one FMU that runs in any FMI tool, without Python and gmfbo."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from gmfbo.errors import ExportError, InputError, did_you_mean
from gmfbo.files.durable import cause, write_whole
from gmfbo.sources.binding.binding import Binding
from gmfbo.sources.export.augmented_file import augmented_twin_file
from gmfbo.sources.export.container import build_container
from gmfbo.sources.export.container_archive import Content, container_archive, descriptions
from gmfbo.sources.export.container_description import ExposedParameter, contradicting_units
from gmfbo.sources.export.container_wiring import End, Wiring, wire_up
from gmfbo.sources.export.exportable import check_exportable, common_platforms, losses
from gmfbo.sources.fmu_file.description import FmuDescription, read_description
from gmfbo.sources.fmu_file.fmu_variable import is_parameter
from gmfbo.sources.fmu_file.models import physics_fmu
from gmfbo.sources.fmu_file.platforms import this_platform
from gmfbo.sources.inspection.trial_run import try_out
from gmfbo.sources.twin.parameter_values import check_parameters
from gmfbo.sources.twin.twin import FmuTwin

FMU_NAME, TWIN_FILE_NAME = "augmented.fmu", "augmented.toml"


@dataclass(frozen=True)
class PhysicsParameter:
    """A parameter of an effect that the diagnosis named.

    Attributes
    ----------
    name : str
        As physics.fmu calls it, such as `coulomb_friction.level`.
    value : float
        [unit] As identified.
    unit : str
        Empty where there is none.
    description : str
        Text for the engineer who edits it.
    """

    name: str
    value: float
    unit: str
    description: str


@dataclass(frozen=True)
class AugmentedFmu:
    """An exported augmented twin.

    Attributes
    ----------
    fmu, twin_file : Path
        The files written.
    platforms : tuple of str
        Folders below `binaries/`, one for each platform on which it runs.
    step : float
        [s] Internal step; communication steps are whole multiples of it.
    dropped : tuple of str
        Abilities of the twin's own FMUs that the exported FMU lacks.
    """

    fmu: Path
    twin_file: Path
    platforms: tuple[str, ...]
    step: float
    dropped: tuple[str, ...]


def export_augmented(
    twin: FmuTwin,
    folder: Path,
    *,
    parameters: Mapping[str, float],
    physics: Sequence[PhysicsParameter],
    settings: Mapping[str, float],
    substeps: int,
    from_rest: bool = False,
) -> AugmentedFmu:
    """Write `augmented.fmu` and the twin file that belongs to it, `augmented.toml`.

    The FMU has the variables of the twin's FMUs, with new start values where parameters were
    refitted, and `physics.<effect>.<parameter>` for each named effect. Stepped at the twin's
    communication step it gives the trajectories of `AugmentedTwin` with the same values.

    Parameters
    ----------
    twin : FmuTwin
        The twin to augment; its own parameter values become start values too.
    folder : Path
        Exists; the two files are written there, both or none.
    parameters : mapping of str to float
        [FMU's unit] Refitted parameters, over the twin's values.
    physics : sequence of PhysicsParameter
        Parameters of the named effects; those of other effects stay zero and hidden.
    settings : mapping of str to float
        Fixed values of physics.fmu, such as `settings.command_lateness` [s].
    substeps : int
        Internal steps within one communication step.
    from_rest : bool
        Leave [initial] out of the twin file: a run then begins at its first reference once the
        twin has settled, since physics may push it away from the state in [initial].

    Raises
    ------
    ExportError
        The twin's FMUs cannot be joined into one that runs; the message says why.
    InputError
        A parameter is unknown, or outside its FMU's bounds.
    """
    if substeps < 1:
        raise InputError(f"substeps: expected 1 or more, got {substeps}")
    binding, step = twin.binding, twin.step / substeps
    values = {**binding.settings, **twin.parameters, **parameters}
    check_parameters(binding, values)
    check_exportable(binding)
    description = read_description(physics_fmu())
    wiring = wire_up(binding, description.path)
    wiring.starts.update(values)
    exposed = _expose(wiring, binding, description, physics, settings)
    held = [*binding.fmus, *([description] if wiring.physics else [])]
    platforms = common_platforms(held)
    content = Content(binding, values, exposed, twin.step, step, platforms)
    file = binding.file.model_copy(update={"initial": {}}) if from_rest else binding.file
    text = augmented_twin_file(file, FMU_NAME, twin.step, content.description, values)
    fmu, twin_file = _write(folder, _tried_archive(wiring, content, text), text)
    folders = tuple(platform.fmi_folders[0] for platform in platforms)
    dropped = (*losses(binding, platforms), *_not_shown(binding, wiring))
    return AugmentedFmu(fmu, twin_file, folders, step, dropped)


def _tried_archive(wiring: Wiring, content: Content, twin_file: str) -> bytes:
    """Build the FMU and run it once, where it has binaries for this machine."""
    with tempfile.TemporaryDirectory(prefix="gmfbo-export-") as place:
        container = build_container(wiring, content.internal_step, Path(place))
        archive = container_archive(container, wiring, content)
        _write(Path(place), archive, twin_file)
        if this_platform().name in {platform.name for platform in content.platforms}:
            try_out(Path(place) / TWIN_FILE_NAME)
    return archive


def _expose(
    wiring: Wiring,
    binding: Binding,
    description: FmuDescription,
    physics: Sequence[PhysicsParameter],
    settings: Mapping[str, float],
) -> tuple[ExposedParameter, ...]:
    if physics and not wiring.physics:
        raise ExportError(
            f"{binding.label}: no port for '{physics[0].name}'; expected [ports] in the twin file"
        )
    known = [n for n, variable in description.variables.items() if is_parameter(variable)]
    for name in (*settings, *(parameter.name for parameter in physics)):
        if name not in known:
            raise InputError(f"physics.fmu has no parameter '{name}'" + did_you_mean(name, known))
    shown = {parameter.name for parameter in physics}
    for name, value in settings.items():
        if wiring.physics and name not in shown:
            wiring.start_unseen(name, wiring.physics, value)
    prefix = "physics"
    while any(name.startswith(f"{prefix}.") for name in binding.variables):
        prefix += "_"  # the twin is an augmented one itself
    exposed = []
    for parameter in physics:
        name = f"{prefix}.{parameter.name}"
        wiring.starts[name] = parameter.value
        wiring.settable[name] = [End(member, parameter.name) for member in wiring.physics]
        unit = "" if parameter.unit == "1" else parameter.unit
        exposed.append(ExposedParameter(name, unit, parameter.description, parameter.value))
    return tuple(exposed)


def _not_shown(binding: Binding, wiring: Wiring) -> Iterator[str]:
    if wiring.hidden:
        yield f"inputs that a wire inside drives: {', '.join(wiring.hidden)}"
    for unit in contradicting_units(descriptions(binding)):
        yield f"one of the meanings that its FMUs give to the unit '{unit}': the first is written"


def _write(folder: Path, archive: bytes, text: str) -> tuple[Path, Path]:
    fmu, twin_file = folder / FMU_NAME, folder / TWIN_FILE_NAME
    try:
        write_whole(fmu, archive)
        write_whole(twin_file, text.encode())
    except OSError as error:
        raise ExportError(f"cannot write into '{folder}': {cause(error)}") from None
    return fmu, twin_file
