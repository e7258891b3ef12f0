"""Zip archives whose bytes depend on their contents only."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping

_EARLIEST = (1980, 1, 1, 0, 0, 0)  # earliest date of the format
_UNIX = 3


def pack(files: Mapping[str, bytes]) -> bytes:
    """Zip with sorted entries, a fixed date and fixed permissions.

    Parameters
    ----------
    files : mapping of str to bytes
        Contents by path inside the archive, with forward slashes.
    """
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, date_time=_EARLIEST)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = _UNIX
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, files[name])
    return buffer.getvalue()
