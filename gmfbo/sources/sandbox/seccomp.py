"""Seccomp: which system calls a process may make (Linux 3.5; linux/seccomp.h, linux/filter.h)."""

from __future__ import annotations

import ctypes
import errno
import os
import platform
import sys
from collections.abc import Iterator

from gmfbo.sources.sandbox import system_calls
from gmfbo.sources.sandbox.kernel import has_filters, renounce_privileges, set_filter
from gmfbo.sources.sandbox.system_calls import Numbers

# Column of the tables, and AUDIT_ARCH of linux/audit.h.
_MACHINES = {"x86_64": (0, 0xC000003E), "aarch64": (1, 0xC00000B7)}
_LOAD, _JUMP_IF_EQUAL, _JUMP_IF_GREATER_OR_EQUAL, _JUMP_IF_ANY_BIT = 0x20, 0x15, 0x35, 0x45
_RETURN = 0x06
_ALLOW, _FAIL_WITH = 0x7FFF0000, 0x00050000
_NUMBER_AT, _MACHINE_AT, _FIRST_ARGUMENT_AT = 0, 4, 16  # in seccomp_data; little-endian low word
_X32 = 0x40000000
_CLONE_THREAD = 0x00010000

_Step = tuple[int, int, int, int]


class _Instruction(ctypes.Structure):
    _fields_ = [
        ("code", ctypes.c_uint16),
        ("if_true", ctypes.c_uint8),
        ("if_false", ctypes.c_uint8),
        ("value", ctypes.c_uint32),
    ]


class _Program(ctypes.Structure):
    _fields_ = [("length", ctypes.c_uint16), ("steps", ctypes.POINTER(_Instruction))]


def is_available() -> bool:
    """Whether the kernel has filters, and its call numbers are known here."""
    return platform.machine() in _MACHINES and sys.maxsize > 2**32 and has_filters()


def restrict(*, network: bool) -> bool:
    """Deny this thread and its children the calls of `system_calls`; returns whether in force.

    A denied call fails with EPERM, an error that an FMU can report; `network` allows sockets.
    """
    if not is_available():
        return False
    steps = list(_program(*_MACHINES[platform.machine()], network=network))
    code = (_Instruction * len(steps))(*(_Instruction(*step) for step in steps))
    renounce_privileges()
    set_filter(_Program(len(steps), code))
    return True


def _program(column: int, machine: int, *, network: bool) -> Iterator[_Step]:
    yield _LOAD, 0, 0, _MACHINE_AT
    yield _JUMP_IF_EQUAL, 1, 0, machine
    yield _fail(errno.EPERM)  # call numbers differ in 32-bit programs
    yield _LOAD, 0, 0, _NUMBER_AT
    yield _JUMP_IF_GREATER_OR_EQUAL, 0, 1, _X32
    yield _fail(errno.EPERM)
    refused = [
        system_calls.PROGRAMS,
        system_calls.ATTRIBUTES,
        system_calls.OTHER_PROCESSES,
        system_calls.LEFT_BEHIND,
        system_calls.KERNEL,
    ]
    for table in refused if network else [system_calls.NETWORK, *refused]:
        for number in _numbers(table, column):
            yield _JUMP_IF_EQUAL, 0, 1, number
            yield _fail(errno.EPERM)
    for number in _numbers(system_calls.OWN_PROCESS, column):
        yield from _only_with_first_argument(number, os.getpid())
    for number in _numbers(system_calls.LIMITS, column):
        yield from _only_with_first_argument(number, 0)
    yield from _threads_only(*_numbers(system_calls.THREADS, column))
    yield _RETURN, 0, 0, _ALLOW


def _only_with_first_argument(number: int, value: int) -> Iterator[_Step]:
    yield _JUMP_IF_EQUAL, 0, 4, number
    yield _LOAD, 0, 0, _FIRST_ARGUMENT_AT
    yield _JUMP_IF_EQUAL, 1, 0, value
    yield _fail(errno.EPERM)
    yield _RETURN, 0, 0, _ALLOW


def _threads_only(clone: int, clone3: int) -> Iterator[_Step]:
    # A filter cannot read the flags of clone3 behind a pointer; without clone3, libc uses clone.
    yield _JUMP_IF_EQUAL, 0, 1, clone3
    yield _fail(errno.ENOSYS)
    yield _JUMP_IF_EQUAL, 0, 4, clone
    yield _LOAD, 0, 0, _FIRST_ARGUMENT_AT
    yield _JUMP_IF_ANY_BIT, 1, 0, _CLONE_THREAD
    yield _fail(errno.EPERM)
    yield _RETURN, 0, 0, _ALLOW


def _numbers(table: Numbers, column: int) -> Iterator[int]:
    for numbers in table.values():
        number = numbers[column]
        if number is not None:
            yield number


def _fail(number: int) -> _Step:
    return _RETURN, 0, 0, _FAIL_WITH | number
