"""The wheel of this checkout, for the tests of what a user installs."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def build_wheel(folder: Path) -> Path:
    """Build the wheel.

    Parameters
    ----------
    folder : Path
        Gets the wheel.

    Returns
    -------
    Path
        The wheel.
    """
    command = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "-o", str(folder)]
    subprocess.run([*command, str(ROOT)], check=True, capture_output=True)
    (wheel,) = folder.glob("*.whl")
    return wheel


def unpack(wheel: Path, site: Path) -> None:
    """Unpack a wheel, which is all that installing a package without scripts does.

    Parameters
    ----------
    wheel : Path
        The wheel.
    site : Path
        Folder of installed packages.
    """
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
