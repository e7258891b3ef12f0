"""Import an SSP package: its FMUs in a folder, and a twin file that joins them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from gmfbo.errors import FmuFileError, InputError
from gmfbo.sources.fmu_file.description import FmuDescription, read_description
from gmfbo.sources.fmu_file.unpacking import unpack
from gmfbo.sources.inspection.ssp_system import End, SspSystem, read_system
from gmfbo.sources.twin_file.toml_lines import bare_key, free_key, toml_table, toml_text

_STEP_S = 1e-3


@dataclass(frozen=True)
class ImportedTwin:
    """Result of an import.

    Attributes
    ----------
    twin : Path
        The twin file.
    fmus, wires, inputs, outputs : int
        Numbers of FMUs, wires, inputs and outputs in it.
    """

    twin: Path
    fmus: int
    wires: int
    inputs: int
    outputs: int


def import_ssp(path: str | Path, folder: str | Path) -> ImportedTwin:
    """Write the FMUs of an SSP 1.0 package and a twin file for them; none of their code runs.

    Parameters
    ----------
    path : str or Path
        The `.ssp` file.
    folder : str or Path
        Made if it is not there.

    Raises
    ------
    FmuFileError
        The package cannot be read, or holds what a twin file cannot express.
    InputError
        A twin file of that name lies in the folder already.
    TwinFileError
        A connector is no variable of its FMU.
    """
    path, folder = Path(path), Path(folder)
    system = read_system(path)
    twin = folder / f"{bare_key(system.name)}.toml"
    if twin.exists():
        raise InputError(f"'{twin}' is there already; give another --out, or move it away")
    wanted = set(system.fmus.values())
    # What is refused leaves nothing behind.
    with TemporaryDirectory(prefix="gmfbo-import-") as apart:
        trial = Path(apart)
        unpack(path, trial, lambda member: str(member) in wanted)
        fmus = {name: read_description(trial / member) for name, member in system.fmus.items()}
        _check_units(path, system, fmus)
        text = _twin_text(system, fmus)
        _check(text, path.name, trial)
    folder.mkdir(parents=True, exist_ok=True)
    unpack(path, folder, lambda member: str(member) in wanted)
    twin.write_text(text, encoding="utf-8")
    outputs = len(system.outputs or system.offered)
    return ImportedTwin(twin, len(fmus), len(system.wires), len(system.inputs), outputs)


def _check(text: str, label: str, folder: Path) -> None:
    """Raise for a name that no FMU has, before the twin file is written."""
    from gmfbo.sources.binding.bind import bind
    from gmfbo.sources.twin_file.twin_file import TwinFile

    bind(TwinFile.parse(text, label, folder), folder, label)


def _check_units(path: Path, system: SspSystem, fmus: Mapping[str, FmuDescription]) -> None:
    """Raise where a connection joins different units: SSP converts them, wires do not."""
    for end, source in system.wires.items():
        ends = [fmus[place].variables.get(name) for place, name in (end, source)]
        if None in ends:
            continue  # reported when the twin file is bound
        into, out_of = ends
        assert into is not None
        assert out_of is not None
        same = (into.to_si, into.si_zero) == (out_of.to_si, out_of.si_zero)
        if into.unit and out_of.unit and not same:
            raise FmuFileError(
                f"'{path.name}': the connection of '{source[0]}.{source[1]}' [{out_of.unit}] to "
                f"'{end[0]}.{end[1]}' [{into.unit}] converts units: expected equal ones"
            )


def _twin_text(system: SspSystem, fmus: Mapping[str, FmuDescription]) -> str:
    steps = [fmu.default_step for fmu in fmus.values() if fmu.default_step]
    stated = "smallest that an FMU states" if steps else "a guess: no FMU states one"
    taken: set[str] = set()
    inputs = []
    for end, name in system.inputs.items():
        key, first = free_key(bare_key(name), taken), bare_key(name)
        entry = _name(end)
        if key != first:  # one input of the system drives several of the FMUs
            entry = f"{{ variable = {entry}, column = {toml_text(first)} }}"
        inputs.append(f"{key} = {entry}")
    shown = system.outputs.items() or [("_".join(end), end) for end in system.offered]
    blocks = (
        f"name = {toml_text(system.name)}\nstep = {min(steps, default=_STEP_S)!r}"
        f"  # [s] communication step, {stated}\n",
        toml_table(
            "fmus",
            "in the order in which they compute, as the package lists them",
            (f"{bare_key(name)} = {toml_text(member)}" for name, member in system.fmus.items()),
        ),
        toml_table(
            "wires",
            "input = output",
            (f"{_name(end)} = {_name(source)}" for end, source in system.wires.items()),
        ),
        toml_table("inputs", "recorded signal = FMU input it drives", inputs),
        toml_table(
            "outputs",
            "recorded signal = FMU output it is compared with",
            (f"{free_key(bare_key(name), taken)} = {_name(end)}" for name, end in shown),
        ),
        toml_table(
            "parameters",
            "values that the package sets",
            (f"{_name(end)} = {value!r}" for end, value in system.parameters.items()),
        ),
    )
    return "\n".join(block for block in blocks if block)


def _name(end: End) -> str:
    return toml_text(f"{bare_key(end[0])}.{end[1]}")
