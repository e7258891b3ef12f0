"""Building: the committed FMUs come from these sources, and a build leaves nothing else behind."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

import pytest

from fmu_build.archive import members
from fmu_build.build import (
    FRONT_PLATFORMS,
    MODELS,
    SOURCES,
    TEST_FMUS,
    build_all,
    main,
    model_folders,
    plain_folders,
)
from fmu_build.compile import find_compiler
from fmu_build.declaration import read_declaration
from fmu_build.failure import BuildError
from fmu_build.fault_fmus import read_faults
from fmu_build.fmu import build_fmu
from fmu_build.platforms import PLATFORMS, this_platform
from tests.fmu_build.fmu_instance import FmuInstance, unpacked_fmu

HERE = [this_platform().name]


def silent(line: str) -> None:
    """Swallow progress."""


def test_committed_fmus_and_libraries_are_what_their_sources_give() -> None:
    """Byte for byte, for this machine's platform; `gmfbo build --check` does it for all five."""
    lines: list[str] = []
    build_all(MODELS, platforms=HERE, check=True, report=lines.append)
    versions = [read_declaration(folder / "model.toml").fmi for folder in model_folders()]
    by_hand = len(plain_folders()) + len(read_faults()) + len(["master", "front"])
    assert len(lines) == sum(map(len, versions)) + by_hand
    assert all(line.endswith("unchanged") for line in lines)


def test_every_committed_fmu_carries_all_five_platforms() -> None:
    folders = {
        False: {platform.fmi_folder for platform in PLATFORMS.values()},
        True: {platform.fmi3_folder for platform in PLATFORMS.values()},
    }
    for path in sorted(MODELS.glob("*.fmu")):
        held = {name.split("/")[1] for name in members(path.read_bytes()) if "binaries/" in name}
        assert held == folders[path.stem.endswith("_fmi3")], path.name
    for platform in PLATFORMS.values():
        library = MODELS / "master" / platform.name / f"gmfbo_master{platform.suffix}"
        assert library.stat().st_size < 200_000
    for name in FRONT_PLATFORMS:
        library = MODELS / "front" / name / f"gmfbo_front{PLATFORMS[name].suffix}"
        assert library.stat().st_size < 200_000


def test_a_universal_library_holds_one_slice_for_each_kind_of_mac() -> None:
    library = members((MODELS / "pid.fmu").read_bytes())["binaries/darwin64/pid.dylib"]
    assert library[:8] == bytes.fromhex("cafebabe00000002")
    processors = []
    for index in range(2):
        entry = library[8 + 20 * index : 28 + 20 * index]
        processor, _, offset, size, alignment = (
            int.from_bytes(entry[i : i + 4], "big") for i in range(0, 20, 4)
        )
        assert offset % 2**alignment == 0
        assert library[offset : offset + 4] == bytes.fromhex("cffaedfe")  # 64-bit, little-endian
        assert offset + size <= len(library)
        processors.append(processor)
    assert processors == [0x01000007, 0x0100000C]  # x86-64, ARM 64


def test_two_builds_from_two_folders_give_the_same_bytes(tmp_path: Path) -> None:
    for name in ("one", "a longer second name"):
        build_all(tmp_path / name, ["pd_filtered"], platforms=HERE, report=silent)
    first, second = (path.read_bytes() for path in sorted(tmp_path.glob("*/pd_filtered.fmu")))
    assert first == second


@pytest.mark.slow
def test_a_build_leaves_only_its_products(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(scratch))
    monkeypatch.delenv("ZIG_GLOBAL_CACHE_DIR")
    monkeypatch.chdir(tmp_path)
    sources = sorted(path for path in SOURCES.rglob("*") if "__pycache__" not in path.parts)
    build_all(tmp_path / "out", ["pid", "master"], platforms=HERE, report=silent)
    assert list(scratch.iterdir()) == []
    built = sorted(path.name for path in tmp_path.rglob("*") if path.is_file())
    assert built == sorted(["pid.fmu", f"gmfbo_master{this_platform().suffix}"])
    assert sources == sorted(path for path in SOURCES.rglob("*") if "__pycache__" not in path.parts)


def test_an_unchanged_file_is_not_written_again(tmp_path: Path) -> None:
    build_all(tmp_path, ["model_exchange"], report=silent)
    path = tmp_path / "model_exchange.fmu"
    path.chmod(0o444)
    before = path.stat().st_mtime_ns
    lines: list[str] = []
    build_all(tmp_path, ["model_exchange"], report=lines.append)
    assert path.stat().st_mtime_ns == before
    assert lines[0].endswith("unchanged")


def test_a_check_names_what_differs_and_writes_nothing(tmp_path: Path) -> None:
    committed = (TEST_FMUS / "model_exchange.fmu").read_bytes()
    path = tmp_path / "model_exchange.fmu"
    path.write_bytes(committed[:-1] + b"x")
    with pytest.raises(BuildError, match=r"differs in model_exchange\.fmu: run gmfbo build"):
        build_all(tmp_path, ["model_exchange"], check=True, report=silent)
    assert path.read_bytes() == committed[:-1] + b"x"
    path.write_bytes(committed)
    build_all(tmp_path, ["model_exchange"], check=True, report=silent)


def test_the_system_compiler_builds_for_this_machine_only(tmp_path: Path) -> None:
    if shutil.which("cc") or shutil.which("gcc") or shutil.which("clang"):
        build_all(tmp_path, ["pid"], "system", report=silent)
        names = set(members((tmp_path / "pid.fmu").read_bytes()))
        folder, suffix = this_platform().fmi_folder, this_platform().suffix
        assert names == {"modelDescription.xml", f"binaries/{folder}/pid{suffix}"}
    foreign = next(name for name in PLATFORMS if name not in HERE)
    expected = f"cannot build for {foreign}: use --compiler zig|no system compiler"
    with pytest.raises(BuildError, match=expected):
        build_all(tmp_path, ["pid"], "system", platforms=[foreign], report=silent)


def test_an_unknown_model_or_platform_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(BuildError, match=r"no model 'pidd' in fmu_build/; known are .*pid"):
        build_all(tmp_path, ["pidd"], report=silent)
    with pytest.raises(BuildError, match="no platform 'amiga'; known are linux-x86_64"):
        build_all(tmp_path, platforms=["amiga"], report=silent)
    assert main(["--only", "pidd", "--output", str(tmp_path)]) == 2
    assert capsys.readouterr().err.startswith("no model 'pidd'")


def test_a_compiler_error_is_shown_with_model_and_platform(tmp_path: Path, zig_cache: Path) -> None:
    folder = tmp_path / "pid"
    shutil.copytree(SOURCES / "pid", folder)
    shutil.copytree(SOURCES / "controllers", tmp_path / "controllers")
    (folder / "pid.c").write_text("int broken(\n")
    work = tmp_path / "work"
    work.mkdir()
    compiler = find_compiler("zig", zig_cache, [this_platform()])
    with pytest.raises(BuildError, match=r"pid for .* does not compile:\n(.*\n)*.*pid\.c:1"):
        build_fmu(read_declaration(folder / "model.toml"), compiler, [this_platform()], work)


@pytest.mark.parametrize("path", sorted(SOURCES.glob("*/*.mo")), ids=lambda path: path.name)
def test_translating_without_the_translator_says_what_is_needed(
    path: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("sys.version_info", (3, 11, 9, "final", 0))
    with pytest.raises(BuildError, match=r"needs Python 3\.12 or later, this is 3\.11; build"):
        build_all(tmp_path, [path.parent.name], translate=True, report=silent)


LAG = """
#include <math.h>
#include "model.h"
struct Model { double v[N_VARIABLES]; };
const size_t model_bytes = sizeof(struct Model);
const char *model_initialise(Model *m, const char *r) { (void)r; m->v[V_y] = 1.0; return NULL; }
const char *model_step(Model *m, double t, double h) {
    (void)t;
    m->v[V_y] *= exp(-h / m->v[V_lag_time_constant]);
    return NULL;
}
const char *model_parameter_changed(Model *m, int index) { (void)m, (void)index; return NULL; }
"""


def test_the_declaration_in_the_documentation_builds_and_runs(
    tmp_path: Path, zig_cache: Path
) -> None:
    page = (SOURCES.parent / "notebooks" / "docs" / "fmus.md").read_text(encoding="utf-8")
    table = page.split("```toml\n")[1].split("```")[0]
    output = '\n[[variable]]\nname = "y"\ncausality = "output"\ndescription = "Decay from 1"\n'
    folder, work = tmp_path / "first_order", tmp_path / "work"
    folder.mkdir()
    work.mkdir()
    (folder / "model.toml").write_text(table + output)
    (folder / "first_order.c").write_text(LAG)
    compiler = find_compiler("zig", zig_cache, [this_platform()])
    declaration = read_declaration(folder / "model.toml")
    path = tmp_path / "first_order.fmu"
    path.write_bytes(build_fmu(declaration, compiler, [this_platform()], work))
    with unpacked_fmu(path) as unpacked:
        lag = FmuInstance(unpacked).start(lag__time_constant=0.2)
        lag.step(0.0, 0.1)
        assert lag.get("y") == pytest.approx(0.6065306597126334, rel=1e-15)
        lag.close()
