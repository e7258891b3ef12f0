"""SSP packages with hostile structure."""

from __future__ import annotations

import tempfile
import zipfile
from functools import cache
from pathlib import Path

from hypothesis import strategies as st

from tests.fuzz.fmus import archive, hostile_xml
from tests.fuzz.mutation import byte_changes, text_changes
from tests.sources.inspection.test_ssp_import import FLAT, NESTED, pack

_STRUCTURE = "SystemStructure.ssd"


def hostile_packages() -> st.SearchStrategy[bytes]:
    """Packages whose structure has wrong tags, tokens and bytes, and packages with wrong bytes."""
    structures = [members[_STRUCTURE] for members in _packages()]
    changed = st.one_of(hostile_xml(structures), text_changes(structures), byte_changes(structures))
    made = changed.map(lambda text: archive({**_packages()[0], _STRUCTURE: text}))
    whole = [archive(members) for members in _packages()]
    return st.one_of(made, byte_changes(whole))


@cache
def _packages() -> list[dict[str, bytes]]:
    found = []
    for inside in (FLAT, NESTED):
        with (
            tempfile.TemporaryDirectory() as name,
            zipfile.ZipFile(pack(Path(name), inside)) as file,
        ):
            found.append({member: file.read(member) for member in file.namelist()})
    return found
