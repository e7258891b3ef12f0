"""The drive FMU as it is committed."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
if str(ROOT) not in sys.path:  # last, so that an installed gmfbo is the one that is tested
    sys.path.append(str(ROOT))

from tests.drive_twin.drive_runs import Drive  # noqa: E402


@pytest.fixture(scope="session")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Drive:
    """Drive twin with all inputs and outputs."""
    return Drive(tmp_path_factory.mktemp("drive"))
