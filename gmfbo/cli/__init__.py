"""Command line: one file a command, each importing what it needs only when it runs."""

from gmfbo.cli.application import main

__all__ = ["main"]
