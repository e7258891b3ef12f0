"""`gmfbo methods`: the tuning methods, a line and a source each."""

from __future__ import annotations

from gmfbo.cli.console import console


def methods() -> None:
    """List the tuning methods."""
    from gmfbo.tuning.methods import METHODS

    for name, method in METHODS.items():
        console.print(f"{name:<14} {method.summary}")
        console.print(f"{'':<14} source: {method.reference}")
