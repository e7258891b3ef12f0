"""`gmfbo methods`: the tuning methods, a line and a source each."""

from __future__ import annotations

from gmfbo.cli.console import console


def methods() -> None:
    """List the tuning methods."""
    import gmfbo.retuning  # noqa: F401 - adds its methods
    from gmfbo.tuning.methods import all_methods

    for name, method in all_methods().items():
        console.print(f"{name:<16} {method.summary}")
        console.print(f"{'':<16} source: {method.reference}")
