"""The tables of effects in `notebooks/docs/effects.md`, from the catalogue.

`python -m tests.effect_table` writes them anew.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from gmfbo.physics import CATALOGUE, Units
from gmfbo.physics.example_axis import EXAMPLE_AXIS

DOCUMENT = Path(__file__).parents[1] / "notebooks/docs/effects.md"
BEGIN, END = "<!-- effects -->\n", "<!-- end of effects -->\n"


def effect_table() -> str:
    """Return a table for each port with a row an effect, in the catalogue's order."""
    return "\n".join(_lines()) + "\n"


def _lines() -> Iterator[str]:
    units = Units()
    for port in dict.fromkeys(effect.port for effect in CATALOGUE.values()):
        yield from (f"## At the {port} port", "")
        yield "| effect | equation | size | floor | easily confused with |"
        yield "|---|---|---|---|---|"
        for effect in (one for one in CATALOGUE.values() if one.port == port):
            unit = units.resolve(effect.size_unit)
            floor = f"{effect.floor(EXAMPLE_AXIS):.2g}{'' if unit == '1' else f' {unit}'}"
            others = ", ".join(name.replace("_", " ") for name in effect.confused_with)
            cells = (f"`{effect.name}`", f"`{effect.equation}`", effect.size_name, floor, others)
            yield f"| {' | '.join(cells)} |"
        yield ""


def documented_table() -> str:
    """Return the table that the document holds."""
    return DOCUMENT.read_text(encoding="utf-8").partition(BEGIN)[2].partition(END)[0]


def main() -> None:
    """Write the table into the document."""
    head, _, rest = DOCUMENT.read_text(encoding="utf-8").partition(BEGIN)
    DOCUMENT.write_text(head + BEGIN + effect_table() + END + rest.partition(END)[2], "utf-8")


if __name__ == "__main__":
    main()
