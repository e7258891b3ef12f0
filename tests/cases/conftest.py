"""A copy of the case that a test file names in CASE."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cases.case_folder import CASES, CaseFolder, copied


@pytest.fixture
def case(request: pytest.FixtureRequest, tmp_path: Path) -> CaseFolder:
    """The folder of the case, copied to where the test may write."""
    return CaseFolder(copied(CASES, request.module.CASE, tmp_path))
