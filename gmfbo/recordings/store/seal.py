"""Seal: a line at the end of our files that shows damage, and lets one wrong bit be mended.

HDF5 has no checksum of a whole file, so a flipped bit in a plain dataset would go unnoticed.
Readers of HDF5 ignore bytes after the end that the file states.
"""

from __future__ import annotations

import hashlib
import re
import zlib
from dataclasses import dataclass
from typing import Literal

_SEAL = re.compile(rb"\n# gmfbo crc32=([0-9a-f]{8}) blake2b=([0-9a-f]{32})\n\Z")
_LENGTH = len(b"\n# gmfbo crc32= blake2b=\n") + 8 + 32
_POLYNOMIAL = 0xEDB88320
LARGEST_MENDED = 32 * 2**20  # [B] the search for the bit takes about a second for 4 MB


@dataclass(frozen=True)
class Seal:
    """State of a file by its seal.

    Attributes
    ----------
    state : {"intact", "absent", "damaged"}
        `absent`: written by others, by an early version, or cut off.
    crc32, digest : int, str
        As stated; 0 and empty where absent.
    """

    state: Literal["intact", "absent", "damaged"]
    crc32: int = 0
    digest: str = ""


def sealed(content: bytes) -> bytes:
    """Bytes to write: the content and its seal."""
    line = f"\n# gmfbo crc32={zlib.crc32(content):08x} blake2b={_digest(content)}\n"
    return content + line.encode("ascii")


def read_seal(stored: bytes) -> Seal:
    """Check a file against its seal."""
    found = _SEAL.search(stored, max(len(stored) - _LENGTH, 0))
    if found is None:
        return Seal("absent")
    crc32, digest = int(found[1], 16), found[2].decode("ascii")
    content = stored[: found.start()]
    # One valid checksum suffices: the wrong bit may be in the seal itself.
    whole = zlib.crc32(content) == crc32 or _digest(content) == digest
    return Seal("intact" if whole else "damaged", crc32, digest)


def without_seal(stored: bytes) -> bytes:
    """Content of a file, whether or not it has a seal."""
    found = _SEAL.search(stored, max(len(stored) - _LENGTH, 0))
    return stored if found is None else stored[: found.start()]


def mended(stored: bytes) -> tuple[bytes, int] | None:
    """Correct a single wrong bit.

    The difference of the stated and the computed CRC-32 depends on the wrong bits alone. Stepped
    back through the file, it equals the difference by a single bit at that bit's place.

    Returns
    -------
    tuple or None
        The original file, and the wrong byte's index; None where more than one bit is wrong.
    """
    seal, content = read_seal(stored), without_seal(stored)
    if seal.state != "damaged" or len(content) > LARGEST_MENDED:
        return None
    place = wrong_bit(content, seal.crc32)
    if place is None:
        return None
    byte, bit = place
    corrected = bytearray(content)
    corrected[byte] ^= 1 << bit
    # Damage of many bits may look like that of one: the digest decides.
    if _digest(corrected) != seal.digest:
        return None
    return bytes(corrected) + stored[len(content) :], byte


def wrong_bit(content: bytes, crc32: int) -> tuple[int, int] | None:
    """Byte and bit whose turning would give this CRC-32; None where no single one does."""
    difference = zlib.crc32(content) ^ crc32
    for byte in range(len(content) - 1, -1, -1):
        if difference in _BIT:
            return byte, _BIT[difference]
        index = _BY_TOP[difference >> 24]
        difference = ((difference ^ _TABLE[index]) << 8 & 0xFFFFFFFF) | index
    return None


def _digest(content: bytes | bytearray) -> str:
    return hashlib.blake2b(content, digest_size=16).hexdigest()


def _row(byte: int) -> int:
    for _ in range(8):
        byte = (byte >> 1) ^ (_POLYNOMIAL if byte & 1 else 0)
    return byte


_TABLE = [_row(byte) for byte in range(256)]
_BY_TOP = {value >> 24: byte for byte, value in enumerate(_TABLE)}
_BIT = {_TABLE[1 << bit]: bit for bit in range(8)}
