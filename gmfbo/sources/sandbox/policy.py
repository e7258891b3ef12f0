"""Sandbox policy: rights of FMUs, by the environment variable GMFBO_SANDBOX."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from gmfbo.errors import InputError

VARIABLE = "GMFBO_SANDBOX"
_EXPECTED = (
    f"{VARIABLE}: expected 'off', or any of 'network', 'read=FOLDER' and 'memory=GB', with commas "
    "between"
)


@dataclass(frozen=True)
class Policy:
    """Rights of FMUs.

    The policy is no entry of a twin file, since a file from a stranger must not grant rights.

    Attributes
    ----------
    enclosed : bool
        Whether the sandbox is on; without it an FMU has all rights of the user.
    network : bool
        Whether an FMU may open connections, such as to a licence server.
    read : tuple of str
        Files or folders that an FMU may read besides its own and the system's.
    memory : int
        [bytes] Largest memory of an FMU's process; 0 for half of the machine's.
    """

    enclosed: bool = True
    network: bool = False
    read: tuple[str, ...] = ()
    memory: int = 0

    @classmethod
    def from_environment(cls, environment: Mapping[str, str] = os.environ) -> Policy:
        """Read GMFBO_SANDBOX; without it everything is shut off.

        Raises
        ------
        InputError
            A word is unknown, a folder does not exist, or a number is invalid.
        """
        policy = cls()
        for word in environment.get(VARIABLE, "").split(","):
            policy = _with(policy, word.strip())
        return policy

    def as_dict(self) -> dict[str, Any]:
        """Plain values, for another process."""
        return asdict(self)

    @classmethod
    def from_json(cls, raw: Mapping[str, Any]) -> Policy:
        """Read back what `json.dumps(policy.as_dict())` wrote."""
        return cls(raw["enclosed"], raw["network"], tuple(raw["read"]), raw["memory"])

    @property
    def memory_limit(self) -> int:
        """[bytes] Memory limit; 0 where the machine's memory is unknown."""
        if self.memory:
            return self.memory
        try:
            return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2
        except (AttributeError, ValueError, OSError):
            return 0


_SHUT_OUT = re.compile(
    r"not permitted|permission denied|access (is )?denied|licen[cs]e|socket|connect|spawn|fork|"
    r"subprocess|start (the |a )?process|execut(e|ing) (the |a )?(process|program|command)",
    re.IGNORECASE,
)
"""Words of FMUs for what the sandbox refuses: EPERM and EACCES, and what they tried."""


def way_out(policy: Policy, message: str) -> str:
    """Words for a failed run that the sandbox may have caused, to append; empty for others.

    Parameters
    ----------
    policy : Policy
        In force.
    message : str
        Of the FMU.
    """
    if not policy.enclosed or not _SHUT_OUT.search(message):
        return ""
    ways = [] if policy.network else [f"{VARIABLE}=network lets it open connections"]
    ways += [f"{VARIABLE}=read=PATH lets it read that", f"{VARIABLE}=off lets it do all you may"]
    return f"; gmfbo shuts FMUs in, without programs, connections, your files: {', '.join(ways)}"


def _with(policy: Policy, word: str) -> Policy:
    name, _, value = word.partition("=")
    if word in ("", "on"):
        return policy
    if word == "off":
        return replace(policy, enclosed=False)
    if word == "network":
        return replace(policy, network=True)
    if name == "read" and value:
        place = Path(value).expanduser()
        if not place.exists():
            raise InputError(f"{VARIABLE}: no file or folder '{value}'; check read=")
        return replace(policy, read=(*policy.read, str(place.resolve())))
    if name == "memory":
        return replace(policy, memory=_bytes(value))
    raise InputError(f"{_EXPECTED}; got '{word}'")


def _bytes(gigabytes: str) -> int:
    try:
        size = float(gigabytes) * 1e9
    except ValueError:
        size = math.nan
    if not 1e8 <= size < 1e18:
        raise InputError(f"{VARIABLE}: expected memory = at least 0.1 GB, got '{gigabytes}'")
    return int(size)
