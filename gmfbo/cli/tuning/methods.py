"""`gmfbo methods`: list the tuning methods, each with its publication."""

from __future__ import annotations

from gmfbo.cli.console import console
from gmfbo.cli.manual import Manual

MANUAL = Manual(
    examples={"Which there are:": "gmfbo methods"},
    see_also=("gmfbo tune", "gmfbo compare", "notebooks/docs/tuning.md"),
)


def methods() -> None:
    """List the tuning methods, with the source of each.

    Those of gmfbo and those that installed packages add.
    """
    import gmfbo.retuning  # noqa: F401 - adds its methods
    from gmfbo.tuning.methods import all_methods
    from gmfbo.tuning.study_file.study_sections import DEFAULT_METHOD

    for name, method in all_methods().items():
        chosen = " (default)" if name == DEFAULT_METHOD else ""
        console.print(f"{name:<16} {method.summary}{chosen}")
        console.print(f"{'':<16} source: {method.reference}")
