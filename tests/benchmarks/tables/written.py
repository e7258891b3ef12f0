"""Where each table stands; its first line says which one it is."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from tests.benchmarks.tables import diagnosis, plant_rivals, plant_variants, plants, tuning

ROOT = Path(__file__).resolve().parents[3]
README = "README.md"
_TUNING, _BLIND = "notebooks/docs/tuning_benchmark.md", "notebooks/docs/blind_benchmark.md"
TABLES: tuple[tuple[str, Callable[[], str]], ...] = (
    (README, plants.for_readme),
    (README, diagnosis.for_readme),
    (_TUNING, plants.every_plant),
    (_TUNING, plant_variants.cheap_rivals),
    (_TUNING, plant_variants.misled),
    (_TUNING, plant_variants.leaving),
    (_TUNING, plant_rivals.others),
    (_TUNING, plant_rivals.by_noise),
    (_TUNING, plant_rivals.limited),
    (_TUNING, tuning.all_methods),
    (_TUNING, tuning.by_noise),
    (_TUNING, tuning.by_initial_runs),
    (_TUNING, tuning.made),
    (_BLIND, diagnosis.asked),
    (_BLIND, diagnosis.nulls),
    (_BLIND, diagnosis.odds),
    (_BLIND, diagnosis.worth_of_claims),
    (_BLIND, diagnosis.beside_others),
)


def documented(text: str, table: str) -> str:
    """The table of a document that begins with the first line of this one.

    Parameters
    ----------
    text : str
        The document.
    table : str
        What it should hold.

    Raises
    ------
    ValueError
        If the document has not just one such table.
    """
    head = table.partition("\n")[0]
    if f"\n{text}".count(f"\n{head}\n") != 1:
        raise ValueError(f"expected one table that begins with {head!r}")
    return head + f"\n{text}".partition(f"\n{head}")[2].partition("\n\n")[0].rstrip("\n") + "\n"


def write(root: Path = ROOT) -> list[str]:
    """Write all tables, and return the documents that changed.

    Parameters
    ----------
    root : Path
        Of the documents.
    """
    changed = []
    for name, make in TABLES:
        document, table = root / name, make()
        text = document.read_text(encoding="utf-8")
        old = documented(text, table)
        if old != table:
            document.write_text(text.replace(old, table, 1), encoding="utf-8")
            changed.append(name)
    return sorted(set(changed))
