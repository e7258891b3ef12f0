"""Universal Mach-O files: FMI 2.0 has one folder for both kinds of Mac."""

from __future__ import annotations

import struct

_MAGIC = 0xCAFEBABE
_ALIGNMENT = 14  # slices begin at multiples of 2^14 bytes, the page of Apple silicon


def join_slices(libraries: list[bytes]) -> bytes:
    """Join thin 64-bit libraries, one for each processor, into one file.

    The header is big-endian (magic, count, then for each slice: processor, its subtype, offset,
    size, log2 of the alignment); processor and subtype are copied from the slice's own header.
    """
    offset = 1 << _ALIGNMENT
    header = struct.pack(">II", _MAGIC, len(libraries))
    body = bytearray()
    for library in libraries:
        processor, subtype = struct.unpack_from("<ii", library, 4)
        body.extend(bytes(-len(body) % (1 << _ALIGNMENT)))
        header += struct.pack(
            ">iiIII", processor, subtype, offset + len(body), len(library), _ALIGNMENT
        )
        body.extend(library)
    return header.ljust(offset, b"\0") + bytes(body)
