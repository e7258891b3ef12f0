"""What a user waits for before anything happens: heavy packages load only where used."""

from __future__ import annotations

import subprocess
import sys

import pytest

HEAVY = ("torch", "gpytorch", "botorch", "fmpy", "h5py", "matplotlib")
NUMERIC = ("numpy", "scipy")


@pytest.mark.parametrize(
    ("statement", "unneeded"),
    [
        ("import gmfbo", HEAVY + NUMERIC),
        ("from gmfbo.cli import main", HEAVY + NUMERIC),  # completion at TAB loads this each time
        ("from gmfbo import Recording", HEAVY),
    ],
)
def test_light_entries_load_no_heavy_package(statement: str, unneeded: tuple[str, ...]) -> None:
    code = f"{statement}; import sys; print([m for m in {unneeded!r} if m in sys.modules])"
    finished = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert finished.stdout.strip() == "[]"


def test_every_public_name_resolves() -> None:
    import gmfbo

    assert all(getattr(gmfbo, name).__name__ == name for name in gmfbo.__all__)
