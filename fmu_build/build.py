"""Builds the project's FMUs and the C master: `gmfbo build`, or this file as a script."""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
if str(ROOT) not in sys.path:  # run as a script, or loaded by its path
    sys.path.insert(0, str(ROOT))

from fmu_build.archive import members  # noqa: E402
from fmu_build.compile import Compiler, CompilerName, find_compiler  # noqa: E402
from fmu_build.declaration import Declaration, read_declaration  # noqa: E402
from fmu_build.failure import BuildError  # noqa: E402
from fmu_build.fault_fmus import build_faults  # noqa: E402
from fmu_build.fmu import WRAPPER, build_fmu, build_plain_fmu  # noqa: E402
from fmu_build.platforms import FOREIGN, PLATFORMS, Platform, this_platform  # noqa: E402
from fmu_build.translate import check_translation, translate_model  # noqa: E402

SOURCES = ROOT / "fmu_build"
MODELS = ROOT / "models"
TEST_FMUS = ROOT / "tests" / "fmus"
MASTER = "gmfbo_master"
FRONT = "gmfbo_front"
FRONT_PLATFORMS = ("linux-x86_64", "windows-x86_64", "macos-aarch64")  # as the export toolbox has
_FRONT_SHARED = ("fmi2.h", "resources.h", "resources.c")
_FRONT_SOURCES = ("front.c", "library.c", "resources.c")


def build_all(
    output: Path,
    only: Sequence[str] = (),
    compiler: CompilerName = "zig",
    translate: bool = False,
    check: bool = False,
    report: Callable[[str], None] = print,
    platforms: Sequence[str] = (),
) -> None:
    """Build FMUs and the C master, write what changed, or compare with what is there.

    Parameters
    ----------
    output : Path
        Folder of the FMUs, normally models/; those that only tests need then go to tests/fmus/.
    only : sequence of str
        Names of models, `master`, `front` or `faults`; all if empty.
    compiler : {"zig", "system"}
        The system's compiler builds for this machine only.
    translate : bool
        Translate Modelica sources to C first (Python 3.12 or later).
    check : bool
        Compare the bytes of a fresh build with the files in `output`, and write nothing; with
        `platforms`, what an FMU holds for others is left aside.
    report : callable
        Gets one line a file.
    platforms : sequence of str
        Names of `PLATFORMS`; all, or with the system's compiler this one, if empty.

    Raises
    ------
    BuildError
        If something does not build, or with `check` if a file differs.
    """
    names = _choose(only)
    for name in names:
        if translate:
            translate_model(SOURCES / name, report)
        check_translation(SOURCES / name)
    targets = _targets(platforms, compiler)
    differing = []
    with tempfile.TemporaryDirectory(prefix="gmfbo-build-") as folder:
        # zig builds system libraries first, for a minute; whoever builds often keeps them.
        cache = Path(os.environ.get("ZIG_GLOBAL_CACHE_DIR", Path(folder) / "cache"))
        chosen = find_compiler(compiler, cache, targets)
        for name in names:
            work = Path(folder) / name
            work.mkdir()
            for path, data in _products(name, chosen, targets, work, output):
                same = path.is_file() and _agree(path, data, whole=not (check and platforms))
                if not same and check:
                    differing.append(path.name)
                elif not same:
                    path.parent.mkdir(parents=True, exist_ok=True)
                    path.write_bytes(data)
                report(f"{path.name}: {len(data)} bytes, {'unchanged' if same else 'new'}")
    if differing:
        files = ", ".join(differing)
        raise BuildError(f"a fresh build differs in {files}: run gmfbo build, commit the result")


def _agree(path: Path, data: bytes, whole: bool) -> bool:
    if whole or path.suffix != ".fmu":
        return path.read_bytes() == data
    there = members(path.read_bytes())
    return all(there.get(name) == content for name, content in members(data).items())


def model_folders() -> list[Path]:
    """Folders with a model.toml, in order of name."""
    return sorted(path.parent for path in SOURCES.glob("*/model.toml"))


def plain_folders() -> list[Path]:
    """Folders with an FMI 3.0 FMU by hand, for the tests: its model description lies there too."""
    return sorted(path.parent for path in SOURCES.glob("*/modelDescription.xml"))


def _choose(only: Sequence[str]) -> list[str]:
    models = [folder.name for folder in (*model_folders(), *plain_folders())]
    known = [*models, "master", "front", "faults"]
    for name in only:
        if name not in known:
            raise BuildError(f"no model '{name}' in {SOURCES.name}/; known are {', '.join(known)}")
    return list(only) or known


def _targets(platforms: Sequence[str], compiler: CompilerName) -> list[Platform]:
    for name in platforms:
        if name not in PLATFORMS:
            raise BuildError(f"no platform '{name}'; known are {', '.join(PLATFORMS)}")
    if not platforms and compiler == "system":
        return [this_platform()]
    return [PLATFORMS[name] for name in platforms or PLATFORMS]


def _products(
    name: str, compiler: Compiler, targets: Sequence[Platform], work: Path, output: Path
) -> Iterator[tuple[Path, bytes]]:
    if name == "master":
        sources = sorted((SOURCES / "master").glob("*.[ch]"))
        for path in sources:
            (work / path.name).write_bytes(path.read_bytes())
        units = [path.name for path in sources if path.suffix == ".c"]
        for target in targets:
            library = compiler.shared_library(work, units, MASTER, target)
            yield output / "master" / target.name / (MASTER + target.suffix), library
    elif name == "front":
        for path in (*(SOURCES / "front").iterdir(), *map(WRAPPER.joinpath, _FRONT_SHARED)):
            (work / path.name).write_bytes(path.read_bytes())
        for target in targets:
            if target.name in FRONT_PLATFORMS:
                library = compiler.shared_library(work, _FRONT_SOURCES, FRONT, target)
                yield output / "front" / target.name / (FRONT + target.suffix), library
    elif name == "faults":
        for file, data in build_faults(compiler, targets, work):
            yield _test_folder(output) / "faults" / file, data
    elif SOURCES / name in plain_folders():
        yield (
            _test_folder(output) / f"{name}.fmu",
            build_plain_fmu(SOURCES / name, compiler, targets, work),
        )
    else:
        declaration = read_declaration(SOURCES / name / "model.toml")
        folder = _test_folder(output) if declaration.test_only else output
        chosen = _platforms_of(declaration, targets)
        if compiler.cache is None and chosen != targets and chosen:
            return  # only zig can build it
        for fmi in declaration.fmi:
            place = work / f"fmi{fmi}"
            place.mkdir()
            suffix = "" if fmi == 2 else f"_fmi{fmi}"
            data = build_fmu(declaration, compiler, chosen, place, fmi)
            yield folder / f"{declaration.name}{suffix}.fmu", data


def _test_folder(output: Path) -> Path:
    return TEST_FMUS if output.resolve() == MODELS else output


def _platforms_of(declaration: Declaration, targets: Sequence[Platform]) -> Sequence[Platform]:
    """Those that the model asks for itself are built in any case."""
    if declaration.platforms is None:
        return targets
    return [{**PLATFORMS, FOREIGN.name: FOREIGN}[name] for name in declaration.platforms]


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line of the script; returns the exit status."""
    parser = argparse.ArgumentParser(description="Build the project's FMUs and the C master.")
    parser.add_argument("--output", type=Path, default=MODELS)
    parser.add_argument("--only", action="append", default=[], metavar="NAME")
    parser.add_argument("--compiler", choices=("zig", "system"), default="zig")
    parser.add_argument("--platform", action="append", default=[], choices=tuple(PLATFORMS))
    parser.add_argument("--translate", action="store_true", help="Modelica to C first")
    parser.add_argument("--check", action="store_true", help="compare, write nothing")
    given = parser.parse_args(arguments)
    try:
        build_all(
            given.output,
            given.only,
            given.compiler,
            given.translate,
            given.check,
            platforms=given.platform,
        )
    except BuildError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
