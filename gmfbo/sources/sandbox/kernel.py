"""Linux system calls without a Python function."""

from __future__ import annotations

import ctypes
import os
from functools import lru_cache

_SET_PARENT_DEATH_SIGNAL, _SET_SECCOMP = 1, 22
_SET_CHILD_SUBREAPER, _SET_NO_NEW_PRIVILEGES = 36, 38
_FILTER = 2
_EFAULT = 14


@lru_cache(maxsize=1)
def _libc() -> ctypes.CDLL:
    return ctypes.CDLL(None, use_errno=True)


def system_call(number: int, *arguments: int | ctypes.Structure | None) -> int:
    """Call the kernel by number; structures go by address.

    Parameters
    ----------
    number : int
        Of the call.
    *arguments
        Integers, structures, or None for a null pointer.

    Raises
    ------
    OSError
        The call failed.
    """
    return _checked(_libc().syscall, number, *arguments)


def end_with_parent(signal_number: int) -> None:
    """Have the kernel send this process a signal when its parent ends."""
    _control(_SET_PARENT_DEATH_SIGNAL, signal_number)


def adopt_orphans() -> None:
    """Become the parent of descendants whose own parent ends."""
    _control(_SET_CHILD_SUBREAPER, 1)


def renounce_privileges() -> None:
    """Let no program started from here on gain rights, as landlock and seccomp require."""
    _control(_SET_NO_NEW_PRIVILEGES, 1)


def set_filter(program: ctypes.Structure | None) -> None:
    """Put a seccomp filter in force."""
    _control(_SET_SECCOMP, _FILTER, program)


def has_filters() -> bool:
    """Whether the kernel has seccomp filters: it then fails at a null pointer."""
    try:
        set_filter(None)
    except OSError as error:
        return error.errno == _EFAULT
    return False


def _control(option: int, *arguments: int | ctypes.Structure | None) -> None:
    padded = [*arguments, 0, 0, 0, 0][:4]
    _checked(_libc().prctl, option, *padded)


def _checked(function: ctypes._NamedFuncPointer, *arguments: int | ctypes.Structure | None) -> int:
    passed = [
        ctypes.byref(argument) if isinstance(argument, ctypes.Structure) else _word(argument)
        for argument in arguments
    ]
    answer = int(function(*passed))
    if answer < 0:
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number))
    return answer


def _word(value: int | ctypes.Structure | None) -> ctypes.c_long:
    assert not isinstance(value, ctypes.Structure)
    return ctypes.c_long(value or 0)
