"""Studies of the linear axis: the plant, and a twin that thinks its mass 1.6 times as large."""

from __future__ import annotations

import json
from pathlib import Path

from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.tuning.study.study import Study

HEAD = """
name = "linear"
method = "{method}"
seed = {seed}
[is1]
twin = {twin}
[is2]
twin = {twin}
parameters = {{ mass = 150.0 }}
"""

REFERENCE = """
[reference]
step = 2e-4
at = 0.05
horizon = 0.4
"""

BUDGET = """
[budget]
iterations = {iterations}
"""


def linear_study(
    folder: Path,
    sections: str = "",
    *,
    method: str = "bo_ei",
    seed: int = 0,
    iterations: int = 4,
    reference: str = REFERENCE,
) -> Study:
    """Write a study file and read it back.

    Parameters
    ----------
    folder : Path
        Made if it does not exist.
    sections : str
        Sections of the study file beside those here.
    method : str
        Name of the method.
    seed : int
        Of the study.
    iterations : int
        Queries after the initial runs.
    reference : str
        The part `[reference]`.
    """
    folder.mkdir(parents=True, exist_ok=True)
    twin = json.dumps((models_folder() / "linear_axis.toml").as_posix())
    text = HEAD.format(method=method, seed=seed, twin=twin) + reference + sections
    path = folder / "linear.toml"
    path.write_text(text + BUDGET.format(iterations=iterations), encoding="utf-8")
    return Study.read(path)
