"""FMUs and twin files that were made, or damaged, to do harm; most by the fuzz campaign."""

from __future__ import annotations

import re
import time
import zipfile
from pathlib import Path

import pytest

from gmfbo.errors import FmuFileError, TwinFileError
from gmfbo.sources.fmu_file import prolog
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.fmu_file.unpacking import unpack
from gmfbo.sources.inspection.inspection import inspect_fmu
from gmfbo.sources.twin_file.twin_file import TwinFile
from tests.fuzz.fmus import archive

_DESCRIPTION = "modelDescription.xml"


@pytest.fixture
def description() -> str:
    with zipfile.ZipFile(models_folder() / "linear_axis.fmu") as file:
        return file.read(_DESCRIPTION).decode()


def fmu(folder: Path, text: str | bytes) -> Path:
    path = folder / "a.fmu"
    path.write_bytes(archive({_DESCRIPTION: text if isinstance(text, bytes) else text.encode()}))
    return path


LAUGHS = "".join(f'<!ENTITY l{k} "{f"&l{k - 1};" * 10}">' for k in range(1, 12))


@pytest.mark.parametrize(
    "kind",
    [
        f'[<!ENTITY l0 "ha">{LAUGHS}]',
        '[<!ENTITY x SYSTEM "file:///etc/passwd">]',
        '[<!ENTITY % p SYSTEM "file:///dev/zero"> %p;]',
        'SYSTEM "http://127.0.0.1:9/a.dtd"',
        "",
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "utf-16 said to be utf-8"])
def test_a_document_type_is_refused_before_any_entity_expands(
    tmp_path: Path, description: str, kind: str, encoding: str
) -> None:
    head, end, tail = description.partition("?>")
    written, _, lie = encoding.partition(" said to be ")
    text = re.sub("utf-8", lie or written, head, flags=re.IGNORECASE)
    text += end + f"<!DOCTYPE a {kind}>" + tail
    with pytest.raises(FmuFileError, match=r"has a document type \(<!DOCTYPE>\), which FMI does"):
        inspect_fmu(fmu(tmp_path, text.encode(written)))


def test_a_description_beyond_any_size_is_refused(
    tmp_path: Path, description: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(prolog, "LARGEST_BYTES", 1000)
    with pytest.raises(FmuFileError, match=r"modelDescription\.xml has 0 MB, expected at most 0"):
        inspect_fmu(fmu(tmp_path, description))


@pytest.mark.parametrize("many", [False, True])
def test_names_that_would_take_the_grammar_all_memory_are_not_held_against_it(
    tmp_path: Path, description: str, many: bool
) -> None:
    """One of a million letters took more than 6 GB; three thousand short ones half a minute."""
    names = [f"v{k}" for k in range(3000)] if many else ["z" * 10**6]
    lines = "".join(
        f'<ScalarVariable name="{name}" valueReference="{9000 + k}"><Real/></ScalarVariable>'
        for k, name in enumerate(names)
    )
    path = fmu(tmp_path, description.replace("</ModelVariables>", lines + "</ModelVariables>"))
    began = time.process_time()
    report = inspect_fmu(path)
    assert time.process_time() - began < 5.0
    assert "names of variables were not held against the grammar" in report.findings[-1]


def test_members_that_are_file_and_folder_at_once_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.fmu"
    path.write_bytes(archive({"resources/x": b"1", "resources/x/y": b"2"}))
    folder = tmp_path / "unpacked"
    folder.mkdir()
    with pytest.raises(FmuFileError, match="the names of its members cannot be those of files"):
        unpack(path, folder, lambda member: True)


def test_a_link_is_unpacked_as_the_text_that_it_is(tmp_path: Path) -> None:
    entry = zipfile.ZipInfo("resources/link")
    entry.create_system, entry.external_attr = 3, 0o120777 << 16
    path = tmp_path / "a.fmu"
    with zipfile.ZipFile(path, "w") as file:
        file.writestr(entry, "/etc/passwd")
    unpack(path, tmp_path, lambda member: True)
    assert not (tmp_path / "resources" / "link").is_symlink()
    assert (tmp_path / "resources" / "link").read_text(encoding="utf-8") == "/etc/passwd"


@pytest.mark.parametrize("place", [10, 30])
def test_a_damaged_head_of_an_archive_is_one_line(tmp_path: Path, place: int) -> None:
    """A version that zipfile does not know, and data that zlib does not."""
    content = bytearray(archive({_DESCRIPTION: b"<a/>" * 100, "resources/a": bytes(range(256))}))
    begin = content.find(b"PK\x01\x02") + 6 if place == 10 else content.find(b"resources/a") + 12
    content[begin : begin + 2] = b"\xff\xff"
    path = tmp_path / "a.fmu"
    path.write_bytes(content)
    with pytest.raises(FmuFileError, match="is damaged or encrypted") as error:
        unpack(path, tmp_path, lambda member: True)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("step = " + "9" * 400, "expected integers of at most 64 bits, got a larger one"),
        ("a = " + "[" * 5000, "tables or lists are nested too deeply"),
        (f"name = 'a'\nstep = 1\n[outputs]\np = 'y'\n[{'a' * 9000}]", r"'aaa+ \.\.\. a+'"),
        ('name = "\\u001b[2J', "not valid TOML"),
    ],
)
def test_a_twin_file_that_no_person_wrote_is_one_line(text: str, match: str) -> None:
    with pytest.raises(TwinFileError, match=match) as error:
        TwinFile.parse(text, "a.toml")
    assert len(str(error.value)) < 3000
    assert str(error.value).isprintable()


def test_a_twin_file_of_many_megabytes_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    with path.open("wb") as file:
        file.truncate(10**9)
    with pytest.raises(TwinFileError, match=r"expected at most 4 MB of text, got 1000 MB.*is it"):
        TwinFile.read(path)
