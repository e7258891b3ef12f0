"""Compare tuning methods on the same seeds: run by run, over many studies.

`compare` runs each method on each seed, judges every run against the true optimum of the plant
(`PlantGrid`, `Goal`), keeps one small text a run (`Outcome`), and writes the tables; `campaign`
does so for many studies. A run is a value (`Unit`) that goes to a worker of an `Engine` and comes
back as one; this process alone writes.
"""

from gmfbo.studies.campaign import campaign, compare
from gmfbo.studies.comparison import Comparison
from gmfbo.studies.goal import Goal
from gmfbo.studies.outcome import Outcome
from gmfbo.studies.plant_grid import PlantGrid

__all__ = ["Comparison", "Goal", "Outcome", "PlantGrid", "campaign", "compare"]
