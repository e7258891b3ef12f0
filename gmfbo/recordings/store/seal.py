"""A line at the end of a file of ours that shows damage, and by which one wrong bit is mended.

HDF5 has no checksum of a whole file, so a flipped bit in a plain dataset would be read as another
value. What stands behind the end that HDF5 knows is ignored by every reader of HDF5.
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
LARGEST_MENDED = 32 * 2**20  # [B] looking for the bit takes about a second each 4 MB


@dataclass(frozen=True)
class Seal:
    """What the end of a file says of the bytes before it.

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
    """Hold a file against its seal.

    Parameters
    ----------
    stored : bytes
        All of the file.
    """
    found = _SEAL.search(stored, max(len(stored) - _LENGTH, 0))
    if found is None:
        return Seal("absent")
    crc32, digest = int(found[1], 16), found[2].decode("ascii")
    content = stored[: found.start()]
    # Either of them suffices: the wrong bit may be one of the seal's own.
    whole = zlib.crc32(content) == crc32 or _digest(content) == digest
    return Seal("intact" if whole else "damaged", crc32, digest)


def without_seal(stored: bytes) -> bytes:
    """Content of a file, whether or not it has a seal."""
    found = _SEAL.search(stored, max(len(stored) - _LENGTH, 0))
    return stored if found is None else stored[: found.start()]


def mended(stored: bytes) -> tuple[bytes, int] | None:
    """Turn back the one bit that is wrong.

    The difference of a stated and a computed CRC-32 is that of the wrong bits alone; stepped back
    through the file it meets the difference of a single bit at that bit's place.

    Parameters
    ----------
    stored : bytes
        All of the file, with a seal.

    Returns
    -------
    tuple or None
        The file as it was, and which byte (from 0) was wrong; None where more than one bit is.
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
    # Damage of many bits may look like that of one: the second sum decides.
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
