"""Methods of the side table by name."""

from __future__ import annotations

from collections.abc import Callable

from gmfbo.tuning.query.method import Method
from tests.benchmarks.plants.catalogue import Plant
from tests.benchmarks.plants.peers import StockLogEi, TextbookRule
from tests.benchmarks.plants.side.ax_default import AxDefault
from tests.benchmarks.plants.side.constrained_ei import ConstrainedEi
from tests.benchmarks.plants.side.is3_variants import IS3_NONE, IS3_SOURCE
from tests.benchmarks.plants.side.nelder_mead import NelderMead
from tests.benchmarks.plants.side.turbo import Turbo

Make = Callable[[Plant, int, int], Method]
"""From the plant, its number of initial real runs and the seed to a method for one study."""

RIVALS: dict[str, Make] = {
    "log_ei": lambda plant, initial, seed: StockLogEi(),
    "textbook_rule": lambda plant, initial, seed: TextbookRule(plant.name, initial),
    "ax": lambda plant, initial, seed: AxDefault(seed),
    "nelder_mead": lambda plant, initial, seed: NelderMead(),
    "turbo": lambda plant, initial, seed: Turbo(initial),
    "constrained_ei": lambda plant, initial, seed: ConstrainedEi(dict(plant.safety)),
    "is3_source": lambda plant, initial, seed: IS3_SOURCE,
    "is3_none": lambda plant, initial, seed: IS3_NONE,
}
