"""Libraries as vendors ship them: other names, functions left out, dependencies missing."""

from __future__ import annotations

import re
import sys
import zipfile
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from gmfbo import FmuTwin, step_reference
from gmfbo.errors import FmuFileError
from gmfbo.sources.fmu_file.description import read_description
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.fmu_file.platforms import Platform, this_platform
from tests.sources.conftest import AXIS

if TYPE_CHECKING:
    from tests.sources.conftest import Repack, WriteTwin

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="edits ELF libraries")

REFERENCE = step_reference(0.01, at=0.05, horizon=0.1, unit="m")
FMU = models_folder() / "linear_axis.fmu"
LIBRARY = f"binaries/{this_platform().fmi_folders[0]}/linear_axis.so"


def library() -> bytes:
    with zipfile.ZipFile(FMU) as archive:
        return archive.read(LIBRARY)


def with_library(repack: Repack, old: bytes, new: bytes) -> Path:
    assert old in library()
    assert len(old) == len(new)
    return repack(members={LIBRARY: library().replace(old, new)})


@pytest.mark.parametrize("isolated", [True, False])
def test_a_library_that_cannot_be_loaded_is_a_bad_file_not_a_failed_run(
    isolated: bool, repack: Repack, write_twin: WriteTwin
) -> None:
    fmu = with_library(repack, b"libc.so.6\0", b"libq.so.9\0")
    with (
        FmuTwin(write_twin(AXIS, fmu), isolated=isolated) as twin,
        pytest.raises(
            FmuFileError,
            match=re.escape(
                "'repacked.fmu': its library cannot be loaded: it needs the system library "
                "libq.so.9, which is not installed; install the package that provides libq.so.9"
            ),
        ),
    ):
        twin.run({}, REFERENCE)


def test_a_library_for_another_machine_is_told_as_such(
    repack: Repack, write_twin: WriteTwin
) -> None:
    with zipfile.ZipFile(FMU) as archive:
        dll = archive.read("binaries/win64/linear_axis.dll")
        arm = archive.read("binaries/aarch64-linux/linear_axis.so")
    for foreign in (dll, arm):
        with (
            FmuTwin(write_twin(AXIS, repack(members={LIBRARY: foreign}))) as twin,
            pytest.raises(FmuFileError, match="it was built for another kind of machine than the"),
        ):
            twin.run({}, REFERENCE)


def test_the_working_folder_stays_when_loading_fails(repack: Repack, write_twin: WriteTwin) -> None:
    before = Path.cwd()
    fmu = with_library(repack, b"libc.so.6\0", b"libq.so.9\0")
    with (
        FmuTwin(write_twin(AXIS, fmu), isolated=False) as twin,
        pytest.raises(FmuFileError, match="cannot be loaded"),
    ):
        twin.run({}, REFERENCE)
    assert Path.cwd() == before


def test_optional_functions_may_be_missing(
    repack: Repack, write_twin: WriteTwin, axis: Path
) -> None:
    with FmuTwin(axis) as whole:
        expected = whole.run({}, REFERENCE).signal("position")
    fmu = with_library(repack, b"\0fmi2GetStringStatus\0", b"\0fmi2GetStringStatuX\0")
    with FmuTwin(write_twin(AXIS, fmu)) as twin:
        assert np.array_equal(twin.run({}, REFERENCE).signal("position"), expected)


def test_a_missing_required_function_is_named(repack: Repack, write_twin: WriteTwin) -> None:
    fmu = with_library(repack, b"\0fmi2DoStep\0", b"\0fmi2DoSteX\0")
    with (
        FmuTwin(write_twin(AXIS, fmu)) as twin,
        pytest.raises(FmuFileError, match="its library lacks fmi2DoStep; expected FMI"),
    ):
        twin.run({}, REFERENCE)


def test_a_library_named_other_than_its_identifier_is_found(
    repack: Repack, write_twin: WriteTwin
) -> None:
    fmu = repack(rename={LIBRARY: LIBRARY.replace("linear_axis", "model_v2")})
    with FmuTwin(write_twin(AXIS, fmu)) as twin:
        assert twin.run({}, REFERENCE).status == "ok"


def test_of_several_libraries_none_is_guessed(repack: Repack, write_twin: WriteTwin) -> None:
    other = LIBRARY.replace("linear_axis", "helper")
    fmu = repack(rename={LIBRARY: LIBRARY.replace("linear_axis", "model_v2")}, members={other: b""})
    with pytest.raises(FmuFileError, match=r"linear_axis\.so, found helper\.so, model_v2\.so; ask"):
        FmuTwin(write_twin(AXIS, fmu))


def test_a_guid_that_the_library_does_not_know_is_a_refusal_with_its_words(
    repack: Repack, write_twin: WriteTwin
) -> None:
    fmu = repack(edits={'guid="[0-9a-f]+"': 'guid="0"'})
    with FmuTwin(write_twin(AXIS, fmu)) as twin:
        refused = twin.run({}, REFERENCE)
    assert refused.status == "failed"
    assert "refused fmi2Instantiate: linear_axis cannot be instantiated: the guid differs" in (
        refused.message
    )


@pytest.mark.parametrize(
    ("platform", "member"),
    [
        (Platform("linux-x86_64", ("linux64", "x86_64-linux"), ".so"), "linux64/linear_axis.so"),
        (Platform("linux-aarch64", ("aarch64-linux",), ".so"), "aarch64-linux/linear_axis.so"),
        (Platform("windows-x86_64", ("win64",), ".dll"), "win64/linear_axis.dll"),
        (Platform("macos-aarch64", ("darwin64",), ".dylib"), "darwin64/linear_axis.dylib"),
    ],
)
def test_each_platform_has_its_library(platform: Platform, member: str) -> None:
    assert read_description(FMU).library(platform) == f"binaries/{member}"


def test_a_platform_without_library_is_told_what_there_is() -> None:
    lonely = Platform("linux-riscv64", ("riscv64-linux",), ".so")
    with pytest.raises(
        FmuFileError,
        match=re.escape(
            "has no binary for this machine (linux-riscv64): expected a library in "
            "binaries/riscv64-linux, it has aarch64-linux, darwin64, linux64, win64; ask its "
            "vendor for an FMI 2.0 co-simulation export with binaries/riscv64-linux, or use it on "
            "Linux or Windows or macOS"
        ),
    ):
        read_description(FMU).library(lonely)
