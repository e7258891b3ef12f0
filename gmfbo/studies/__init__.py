"""Methods compared on the same seeds: many studies at once, kept run by run, told as tables.

`compare` runs each method on each seed, judges every run against the true optimum of the plant
(`PlantGrid`, `Goal`), keeps one small text a run (`Outcome`), and writes the tables.
"""

from gmfbo.studies.comparison import Comparison, compare
from gmfbo.studies.goal import Goal
from gmfbo.studies.outcome import Outcome
from gmfbo.studies.plant_grid import PlantGrid

__all__ = ["Comparison", "Goal", "Outcome", "PlantGrid", "compare"]
