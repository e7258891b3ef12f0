"""Files whose package is not installed."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest


@pytest.mark.parametrize(
    ("ending", "package", "extra"),
    [("parquet", "pyarrow", "parquet"), ("mf4", "asammdf", "mdf"), ("tdms", "nptdms", "tdms")],
)
def test_the_message_names_the_command_that_installs_it(
    tmp_path: Path, ending: str, package: str, extra: str
) -> None:
    (tmp_path / f"run.{ending}").write_bytes(b"x")
    # A module that is first on the path and is not there, for this process and that which reads.
    (tmp_path / f"{package}.py").write_text(
        f"raise ModuleNotFoundError(name='{package}')\n", encoding="utf-8"
    )
    path = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])
    code = (
        "from gmfbo import Recording\nfrom gmfbo.errors import RecordingError\n"
        f"try: Recording.read(r'{tmp_path / f'run.{ending}'}')\n"
        "except RecordingError as error: print(error)"
    )
    ran = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONPATH": path},
    )
    assert ran.stdout.strip() == (
        f"run.{ending}: expected the package '{package}' to read it, but it is not installed; "
        f"run: pip install 'gmfbo[{extra}]'"
    )
