"""The table of effects in `notebooks/docs/effects.md`, from the catalogue.

`python -m tests.effect_table` writes it anew.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from gmfbo.physics import CATALOGUE, Units
from gmfbo.physics.example_axis import EXAMPLE_AXIS

DOCUMENT = Path(__file__).parents[1] / "notebooks/docs/effects.md"
BEGIN, END = "<!-- effects -->\n", "<!-- end of effects -->\n"


def effect_table() -> str:
    """Return one row an effect, in the catalogue's order."""
    return "\n".join(_lines()) + "\n"


def _lines() -> Iterator[str]:
    yield "| effect | port | equation | size | floor | easily confused with |"
    yield "|---|---|---|---|---|---|"
    units = Units()
    for effect in CATALOGUE.values():
        unit = units.resolve(effect.size_unit)
        size = effect.size_name if unit == "1" else f"{effect.size_name} [{unit}]"
        others = ", ".join(name.replace("_", " ") for name in effect.confused_with)
        cells = (
            f"`{effect.name}`",
            effect.port,
            f"`{effect.equation}`",
            size,
            f"{effect.floor(EXAMPLE_AXIS):.2g}",
            others,
        )
        yield f"| {' | '.join(cells)} |"


def documented_table() -> str:
    """Return the table that the document holds."""
    return DOCUMENT.read_text(encoding="utf-8").partition(BEGIN)[2].partition(END)[0]


def main() -> None:
    """Write the table into the document."""
    head, _, rest = DOCUMENT.read_text(encoding="utf-8").partition(BEGIN)
    DOCUMENT.write_text(head + BEGIN + effect_table() + END + rest.partition(END)[2], "utf-8")


if __name__ == "__main__":
    main()
