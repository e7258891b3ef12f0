"""What a user waits for before anything happens: heavy packages load only where used."""

from __future__ import annotations

import subprocess
import sys

import pytest


@pytest.mark.parametrize(
    "statement",
    [
        "import gmfbo",
        "from gmfbo.cli import main",
        "from gmfbo import Recording",
    ],
)
def test_light_entries_load_no_heavy_package(statement: str) -> None:
    heavy = ("torch", "gpytorch", "botorch", "fmpy", "h5py", "matplotlib")
    code = f"{statement}; import sys; print([m for m in {heavy!r} if m in sys.modules])"
    finished = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert finished.stdout.strip() == "[]"


def test_every_public_name_resolves() -> None:
    import gmfbo

    assert all(getattr(gmfbo, name).__name__ == name for name in gmfbo.__all__)
