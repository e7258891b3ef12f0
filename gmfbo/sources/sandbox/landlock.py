"""Landlock: which files a process may open, TCP, signals (Linux 5.13; linux/landlock.h)."""

from __future__ import annotations

import ctypes
import os
import stat
from collections.abc import Mapping
from enum import IntFlag
from pathlib import Path

from gmfbo.sources.sandbox.kernel import renounce_privileges, system_call

_CREATE_RULESET, _ADD_RULE, _RESTRICT_SELF = 444, 445, 446  # the same on every processor
_ASK_VERSION = 1
_PATH_BENEATH = 1
_TCP_BIND_AND_CONNECT = 0b11
_ABSTRACT_SOCKETS_AND_SIGNALS = 0b11
_TCP_SINCE, _SCOPES_SINCE = 4, 6


class Access(IntFlag):
    """Rights on files and folders, in the kernel's bits."""

    EXECUTE = 1 << 0
    WRITE_FILE = 1 << 1
    READ_FILE = 1 << 2
    READ_DIR = 1 << 3
    REMOVE_DIR = 1 << 4
    REMOVE_FILE = 1 << 5
    MAKE_CHAR = 1 << 6
    MAKE_DIR = 1 << 7
    MAKE_REG = 1 << 8
    MAKE_SOCK = 1 << 9
    MAKE_FIFO = 1 << 10
    MAKE_BLOCK = 1 << 11
    MAKE_SYM = 1 << 12
    REFER = 1 << 13
    TRUNCATE = 1 << 14
    IOCTL_DEV = 1 << 15


READ = Access.READ_FILE | Access.READ_DIR
OVERWRITE = Access.READ_FILE | Access.WRITE_FILE
OWN = (
    READ
    | OVERWRITE
    | Access.TRUNCATE
    | Access.REFER
    | Access.REMOVE_DIR
    | Access.REMOVE_FILE
    | Access.MAKE_DIR
    | Access.MAKE_REG
    | Access.MAKE_FIFO
    | Access.MAKE_SYM
)
_OF_FILES = OVERWRITE | Access.EXECUTE | Access.TRUNCATE | Access.IOCTL_DEV
# First version of the interface that has a right; rights not listed are in version 1.
_SINCE = {Access.REFER: 2, Access.TRUNCATE: 3, Access.IOCTL_DEV: 5}


class _Ruleset(ctypes.Structure):
    _fields_ = [
        ("files", ctypes.c_uint64),
        ("network", ctypes.c_uint64),
        ("scopes", ctypes.c_uint64),
    ]


class _PathBeneath(ctypes.Structure):
    _pack_ = 1
    _fields_ = [("allowed", ctypes.c_uint64), ("parent", ctypes.c_int32)]


def version() -> int:
    """Version of landlock that the kernel offers; 0 where it has none."""
    try:
        return system_call(_CREATE_RULESET, None, 0, _ASK_VERSION)
    except OSError:
        return 0


def restrict(allowed: Mapping[Path, Access], *, network: bool) -> int:
    """Deny this thread and its children all files but the allowed ones.

    Call it while the process has one thread: other threads would stay free.

    Parameters
    ----------
    allowed : mapping of Path to Access
        Rights on a file, or on a folder with all its content; missing paths are ignored.
    network : bool
        Leave TCP alone.

    Returns
    -------
    int
        Version that is in force; 0 where the kernel has none.
    """
    offered = version()
    if not offered:
        return 0
    known = Access(0)
    for right in Access:
        if offered >= _SINCE.get(right, 1):
            known |= right
    rules = _Ruleset(
        known,
        _TCP_BIND_AND_CONNECT if offered >= _TCP_SINCE and not network else 0,
        _ABSTRACT_SOCKETS_AND_SIGNALS if offered >= _SCOPES_SINCE else 0,
    )
    # An older kernel accepts the longer structure if the fields unknown to it are zero.
    ruleset = system_call(_CREATE_RULESET, rules, ctypes.sizeof(rules), 0)
    try:
        for path, access in allowed.items():
            _allow(ruleset, path, access & known)
        renounce_privileges()
        system_call(_RESTRICT_SELF, ruleset, 0)
    finally:
        os.close(ruleset)
    return offered


def _allow(ruleset: int, path: Path, access: Access) -> None:
    try:
        opened = os.open(path, os.O_PATH | os.O_CLOEXEC)
    except OSError:
        return
    try:
        if not stat.S_ISDIR(os.fstat(opened).st_mode):
            access &= _OF_FILES
        system_call(_ADD_RULE, ruleset, _PATH_BENEATH, _PathBeneath(access, opened), 0)
    finally:
        os.close(opened)
