"""The one way a build fails."""

from __future__ import annotations


class BuildError(Exception):
    """A declaration or a compilation failed; the message says where and what to do."""
