"""Command line: one file a command, which imports what it needs when it runs.

`application.main` is the program; `console` and `arguments` hold what commands share.
"""

from gmfbo.cli.application import main

__all__ = ["main"]
