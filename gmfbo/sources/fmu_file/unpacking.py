"""Open and unpack FMU archives safely: within one folder and a bounded size."""

from __future__ import annotations

import errno
import shutil
import zipfile
from collections.abc import Callable
from pathlib import Path, PurePosixPath

from gmfbo.errors import FmuFileError, in_short

# Real FMUs unpack to at most some 20 times their size; a 298 kB file was seen to fill 300 MB.
LARGEST_BYTES = 4 * 2**30
LARGEST_RATIO = 100
RATIO_FREE_BYTES = 64 * 2**20
LARGEST_COUNT = 100_000


def open_archive(path: Path) -> zipfile.ZipFile:
    """Open an FMU for reading; the caller closes it.

    Parameters
    ----------
    path : Path
        The `.fmu` file.

    Raises
    ------
    FmuFileError
        It is missing, cannot be read, is no zip archive, or would unpack to too many bytes.
    """
    if not path.exists():
        raise FmuFileError(f"no FMU at '{path}'; check the path")
    try:
        archive = zipfile.ZipFile(path)
    except zipfile.BadZipFile:
        raise FmuFileError(
            f"'{path}' is no FMU: expected a zip archive; the file is damaged, cut short or of "
            "another kind, export or copy it again"
        ) from None
    except OSError as error:
        raise FmuFileError(f"cannot read '{path}': {error.strerror or error}") from None
    except Exception as error:  # any exception may come out of zipfile's parsing
        raise _damaged(path, error) from None
    try:
        _check_sizes(path, archive)
    except FmuFileError:
        archive.close()
        raise
    return archive


def read_member(path: Path, archive: zipfile.ZipFile, name: str) -> bytes:
    """Content of one member of an archive.

    Raises
    ------
    FmuFileError
        It is damaged or encrypted.
    """
    try:
        return archive.read(name)
    except Exception as error:  # any exception may come out of zipfile, zlib and lzma
        raise _damaged(path, error) from None


def member_path(path: Path, name: str) -> PurePosixPath:
    """Place of an archive member below the folder that it is unpacked to.

    Parameters
    ----------
    path : Path
        The archive, for the message.
    name : str
        Name of the member; some exporters on Windows write backslashes.

    Raises
    ------
    FmuFileError
        The name points outside the folder.
    """
    member = PurePosixPath(name.replace("\\", "/"))
    if member.is_absolute() or ".." in member.parts or ":" in name or "\0" in name:
        raise FmuFileError(
            f"'{path}' is refused: its member '{in_short(name, 100)}' would be written outside the "
            "folder that it is unpacked to; get the FMU from a source you trust"
        )
    return member


def unpack(path: Path, folder: Path, wanted: Callable[[PurePosixPath], bool]) -> None:
    """Unpack the wanted members of an FMU into a folder.

    Parameters
    ----------
    path : Path
        The `.fmu` file.
    folder : Path
        Exists; everything is written below it.
    wanted : callable
        Maps each member's path to whether to write it.

    Raises
    ------
    FmuFileError
        The archive is unsafe, damaged or encrypted, or the disk is full.
    """
    with open_archive(path) as archive:
        members = [(info, member_path(path, info.filename)) for info in archive.infolist()]
        try:
            for info, member in members:
                if not member.name or info.filename.endswith("/") or not wanted(member):
                    continue
                target = folder / member
                target.parent.mkdir(parents=True, exist_ok=True)
                with archive.open(info) as source, target.open("wb") as written:
                    shutil.copyfileobj(source, written)
        except OSError as error:
            if error.errno in _NAMES:
                raise FmuFileError(
                    f"'{path}' is refused: the names of its members cannot be those of files "
                    f"({error.strerror}); export it again"
                ) from None
            if error.errno is None:  # bz2's error for damaged data
                raise _damaged(path, error) from None
            raise FmuFileError(
                f"cannot unpack '{path}' into '{folder}': {error.strerror or error}; free some "
                "space or set TMPDIR to a folder with room"
            ) from None
        except Exception as error:  # any exception may come out of zipfile, zlib and lzma
            raise _damaged(path, error) from None


# A file in place of a folder, a name that is too long, or forbidden characters.
_NAMES = {
    errno.EEXIST,
    errno.EISDIR,
    errno.ENOTDIR,
    errno.ENAMETOOLONG,
    errno.EINVAL,
    errno.EILSEQ,
}


def _damaged(path: Path, error: Exception) -> FmuFileError:
    return FmuFileError(
        f"'{path}' is damaged or encrypted ({in_short(error)}); export or copy it again"
    )


def _check_sizes(path: Path, archive: zipfile.ZipFile) -> None:
    infos = archive.infolist()
    # zipfile reads no more of a member than it declares, so the declared sizes bound the disk.
    unpacked = sum(info.file_size for info in infos)
    packed = path.stat().st_size
    if (
        unpacked > LARGEST_BYTES
        or len(infos) > LARGEST_COUNT
        or (unpacked > RATIO_FREE_BYTES and unpacked > LARGEST_RATIO * packed)
    ):
        raise FmuFileError(
            f"'{path}' is refused: {packed / 1e6:.3g} MB would unpack to "
            f"{unpacked / 1e6:.4g} MB in {len(infos)} files; expected at most "
            f"{LARGEST_RATIO} times its size"
        )
