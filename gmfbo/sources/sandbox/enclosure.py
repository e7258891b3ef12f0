"""Enclose this process in the sandbox, and report which parts are in force."""

from __future__ import annotations

import contextlib
import sys
from dataclasses import dataclass
from pathlib import Path

from gmfbo.sources.sandbox import seccomp
from gmfbo.sources.sandbox.limits import (
    LARGEST_FILE_BYTES,
    MOST_OPEN_FILES,
    forgo_dumps,
    set_limits,
)
from gmfbo.sources.sandbox.policy import Policy

_SYSTEMS = {"win32": "Windows", "darwin": "macOS"}
_TRUNCATION_SINCE, _TCP_SINCE = 3, 4


@dataclass(frozen=True)
class Enclosure:
    """Parts of the sandbox that are available or in force.

    Attributes
    ----------
    landlock : int
        Version of landlock; 0 where there is none.
    seccomp : bool
        Whether system calls are filtered.
    """

    landlock: int = 0
    seccomp: bool = False

    @property
    def is_whole(self) -> bool:
        """Whether files, network and programs are all shut off."""
        return not self.missing

    @property
    def missing(self) -> str:
        """Words for the parts that stay open; empty where none does."""
        parts = []
        if not self.landlock:
            parts.append("it can read and write your files (the kernel has no landlock)")
        elif self.landlock < _TRUNCATION_SINCE:
            parts.append(f"it can empty your files (landlock {_TRUNCATION_SINCE} is needed)")
        if not self.seccomp:
            tcp = " but TCP" if self.landlock >= _TCP_SINCE else ""
            parts.append(f"it can use the network{tcp} and start programs (no seccomp filter here)")
        return "; ".join(parts)


def available() -> Enclosure:
    """Parts that this machine offers; asking shuts nothing off."""
    if sys.platform != "linux":
        return Enclosure()
    from gmfbo.sources.sandbox import landlock

    return Enclosure(landlock.version(), seccomp.is_available())


def enclose(policy: Policy, *, own: list[Path], shared: list[Path]) -> Enclosure:
    """Enclose this process for good, and return the parts in force; it must have one thread.

    Parameters
    ----------
    policy : Policy
        Rights that the user grants.
    own : list of Path
        Folders in which the process may do anything.
    shared : list of Path
        Folders with files that the process may overwrite in place; shortening or removing them
        would crash other processes that map them, and is denied.
    """
    forgo_dumps()
    if policy.enclosed:
        set_limits(policy.memory_limit)
    if sys.platform != "linux" or not policy.enclosed:
        return Enclosure()
    from gmfbo.sources.sandbox import landlock
    from gmfbo.sources.sandbox.readable import readable

    allowed = readable()
    allowed |= {Path(path): landlock.READ for path in policy.read}
    allowed |= dict.fromkeys(own, landlock.OWN)
    allowed |= dict.fromkeys(shared, landlock.OVERWRITE)
    version, filtered = 0, False
    # A container may refuse what its kernel offers, so report the parts in force.
    with contextlib.suppress(OSError):
        version = landlock.restrict(allowed, network=policy.network)
    with contextlib.suppress(OSError):
        filtered = seccomp.restrict(network=policy.network)
    return Enclosure(version, filtered)


def protection(policy: Policy) -> list[str]:
    """Protections in force on this machine while an FMU runs, a line each."""
    here = available()
    if sys.platform != "linux":
        system = _SYSTEMS.get(sys.platform, sys.platform)
        return [
            "runs in a process of its own: its crash is not yours",
            f"no sandbox on {system}: it can do what you can do; run FMUs that you trust",
        ]
    if not policy.enclosed:
        return [
            "runs in a process of its own: its crash is not yours",
            "GMFBO_SANDBOX=off: it can do what you can do",
        ]
    lines = [f"runs in a process of its own, {_parts(here)}"]
    if here.landlock:
        extra = "".join(f", {path}" for path in policy.read)
        lines.append(f"reads its own files, the system's and Python's{extra}; not yours")
        lines.append("writes its own temporary folder only")
    if here.seccomp or here.landlock >= _TCP_SINCE:
        tcp = "" if here.seccomp else " by TCP"
        lines.append("uses the network" if policy.network else f"has no network{tcp}")
    if here.seccomp:
        lines.append("starts no program, reaches no other process")
    lines.append(_limits(policy))
    if here.missing:
        lines.append(f"but {here.missing}: run FMUs that you trust")
    return lines


def _parts(here: Enclosure) -> str:
    names = [f"landlock {here.landlock}"] if here.landlock else []
    names += ["seccomp"] if here.seccomp else []
    return f"shut in by {' and '.join(names)}" if names else "not shut in"


def _limits(policy: Policy) -> str:
    memory = f"{policy.memory_limit / 1e9:.3g} GB of memory, " if policy.memory_limit else ""
    return (
        f"gets at most {memory}{LARGEST_FILE_BYTES / 1e9:.2g} GB a file, {MOST_OPEN_FILES} open "
        "files, and the time limit of the run"
    )
