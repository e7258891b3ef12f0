"""Sealed draw: a file whose hash is shown first, so that a later change would be noticed."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass
from pathlib import Path

from gmfbo.cli.hidden.draw import Draw
from gmfbo.errors import InputError


@dataclass(frozen=True)
class Sealed:
    """A draw in a sealed file.

    Attributes
    ----------
    path : Path
        File with the answer, JSON.
    sha256 : str
        Of the file's bytes, in hexadecimal.
    """

    path: Path
    sha256: str


def seal(drawn: Draw, path: Path) -> Sealed:
    """Write a draw to a file.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    from gmfbo.files.durable import cause, write_whole

    content = json.dumps(asdict(drawn), indent=1).encode() + b"\n"
    try:
        write_whole(path, content)
    except OSError as error:
        raise InputError(f"'{path}' cannot be written: {cause(error)}") from None
    return Sealed(path, hashlib.sha256(content).hexdigest())


def unseal(sealed: Sealed) -> Draw:
    """Read a draw, if its file is unchanged.

    Raises
    ------
    InputError
        The file is gone, or its hash is another.
    """
    try:
        content = sealed.path.read_bytes()
    except OSError:
        raise InputError(
            f"expected the sealed answer in '{sealed.path}', but it cannot be read; "
            "run gmfbo demo again"
        ) from None
    came = hashlib.sha256(content).hexdigest()
    if came != sealed.sha256:
        raise InputError(
            f"'{sealed.path}': expected the hash {sealed.sha256[:12]}... told before the "
            f"diagnosis, got {came[:12]}...: the answer was changed; run gmfbo demo again"
        )
    answer = json.loads(content)
    return Draw(answer["seed"], answer["hidden"], answer["plant"])
