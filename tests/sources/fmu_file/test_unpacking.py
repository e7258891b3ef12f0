"""Archives that are none, that would fill the disk, or that would write elsewhere."""

from __future__ import annotations

import re
import zipfile
from pathlib import Path

import pytest

from gmfbo.errors import FmuFileError
from gmfbo.sources.fmu_file import unpacking
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.fmu_file.unpacking import unpack
from gmfbo.sources.inspection.inspection import inspect_fmu


def archive(path: Path, members: dict[str, bytes]) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for name, content in members.items():
            file.writestr(name, content)
    return path


@pytest.mark.parametrize(
    "name",
    [
        "../outside.txt",
        "resources/../../outside.txt",
        "/outside.txt",
        "C:/outside.txt",
        "resources\\..\\..\\outside.txt",
        "C:\\outside.txt",
    ],
)
def test_no_member_is_written_outside_the_folder(name: str, tmp_path: Path) -> None:
    path = archive(tmp_path / "evil.fmu", {name: b"x", "resources/fine.txt": b"y"})
    folder = tmp_path / "deep" / "folder"
    folder.mkdir(parents=True)
    with pytest.raises(FmuFileError, match=re.escape(f"its member '{name}' would be written out")):
        unpack(path, folder, lambda member: True)
    assert list(folder.iterdir()) == []
    assert not (tmp_path / "outside.txt").exists()
    assert not (tmp_path / "deep" / "outside.txt").exists()


def test_backslashes_of_a_windows_exporter_are_folders(tmp_path: Path) -> None:
    path = archive(tmp_path / "windows.fmu", {"resources\\table.txt": b"1 2"})
    unpack(path, tmp_path, lambda member: True)
    assert (tmp_path / "resources" / "table.txt").read_bytes() == b"1 2"


def test_a_bomb_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    path = archive(tmp_path / "bomb.fmu", {"resources/zeros": bytes(100 * 2**20)})
    assert path.stat().st_size < 2**20
    with pytest.raises(FmuFileError, match=r"would unpack to 104\.9 MB in 1 files; expected at mo"):
        unpack(path, tmp_path, lambda member: True)
    assert [file.name for file in tmp_path.iterdir()] == ["bomb.fmu"]
    with pytest.raises(FmuFileError, match=r"would unpack to 104\.9 MB"):
        inspect_fmu(path)


def test_a_bomb_of_many_files_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(unpacking, "LARGEST_COUNT", 10)
    path = archive(tmp_path / "many.fmu", {f"resources/{i}": b"" for i in range(11)})
    with pytest.raises(FmuFileError, match="in 11 files"):
        unpack(path, tmp_path, lambda member: True)


def test_a_member_that_lies_about_its_size_fills_no_disk(tmp_path: Path) -> None:
    """The declared size is cut to 1000 bytes in both headers; reading ends there."""
    path = archive(tmp_path / "liar.fmu", {"resources/zeros": bytes(10 * 2**20)})
    size = (10 * 2**20).to_bytes(4, "little")
    path.write_bytes(path.read_bytes().replace(size, (1000).to_bytes(4, "little")))
    with pytest.raises(FmuFileError, match="is damaged or encrypted"):
        unpack(path, tmp_path, lambda member: True)
    assert (tmp_path / "resources" / "zeros").stat().st_size <= 2**20


def test_a_text_is_no_fmu(tmp_path: Path) -> None:
    path = tmp_path / "text.fmu"
    path.write_text("name = 'twin'")
    with pytest.raises(FmuFileError, match=r"text\.fmu' is no FMU: expected a zip archive; the"):
        inspect_fmu(path)


def test_a_file_that_was_cut_short_is_no_fmu(tmp_path: Path) -> None:
    whole = (models_folder() / "linear_axis.fmu").read_bytes()
    path = tmp_path / "short.fmu"
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(FmuFileError, match="is no FMU: expected a zip archive; the file is damage"):
        inspect_fmu(path)


def test_a_damaged_member_is_named_as_damage(tmp_path: Path) -> None:
    path = archive(tmp_path / "damaged.fmu", {"resources/table": bytes(range(256)) * 20})
    content = bytearray(path.read_bytes())
    content[60:70] = bytes(10)
    path.write_bytes(content)
    with pytest.raises(FmuFileError, match="is damaged or encrypted"):
        unpack(path, tmp_path, lambda member: True)


def test_a_folder_a_missing_file_and_a_zip_without_description_are_told_apart(
    tmp_path: Path,
) -> None:
    with pytest.raises(FmuFileError, match=r"no FMU at '.*absent\.fmu'; check the path"):
        inspect_fmu(tmp_path / "absent.fmu")
    with pytest.raises(FmuFileError, match=r"cannot read '.*': Is a directory"):
        inspect_fmu(tmp_path)
    path = archive(tmp_path / "photos.zip", {"one.txt": b""})
    with pytest.raises(FmuFileError, match=r"is no FMU: expected a modelDescription\.xml at the t"):
        inspect_fmu(path)


def test_a_description_that_is_no_xml_is_one_line(tmp_path: Path) -> None:
    path = archive(tmp_path / "broken.fmu", {"modelDescription.xml": b"<fmiModelDescription"})
    with pytest.raises(FmuFileError, match=r"'broken\.fmu': modelDescription\.xml cannot be read"):
        inspect_fmu(path)


def test_only_the_wanted_members_are_unpacked(tmp_path: Path) -> None:
    path = archive(tmp_path / "a.fmu", {"sources/a.c": b"x", "resources/t": b"y"})
    unpack(path, tmp_path, lambda member: member.parts[0] == "resources")
    assert sorted(file.name for file in tmp_path.iterdir()) == ["a.fmu", "resources"]
