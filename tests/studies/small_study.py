"""A study of seconds: the linear axis, and a twin of it that is too heavy."""

from __future__ import annotations

from pathlib import Path

from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.studies.outcome import Outcome

STUDY = """
name = "small"
[is1]
twin = "{axis}"
{change}
[is2]
twin = "{axis}"
parameters = {{ "mass" = {mass} }}
[reference]
step = 0.01
at = 0.05
horizon = 0.4
[objective]
normalise = 4
[budget]
initial_is1 = 2
initial_is2 = 4
is1_runs = 5
"""


def write_small_study(folder: Path, *, mass: float = 130.0, change: str = "") -> Path:
    """Write the study file.

    Parameters
    ----------
    folder : Path
        Where.
    mass : float
        [kg] Of the twin; the plant's is 95.1.
    change : str
        A line of `[is1]`.
    """
    path = folder / "small.toml"
    axis = (models_folder() / "linear_axis.toml").as_posix()
    path.write_text(STUDY.format(axis=axis, mass=mass, change=change), encoding="utf-8")
    return path


def outcome(
    method: str = "random",
    seed: int = 0,
    n_star: int | None = None,
    *,
    n_star_paper: int | None = None,
    regret: tuple[float, ...] = (1.0, 0.5),
    seconds: tuple[float, ...] = (0.5,),
    alarms: tuple[int, ...] | None = None,
) -> Outcome:
    """An outcome as a study of five real runs might leave it."""
    return Outcome(
        study="a study",
        method=method,
        seed=seed,
        n_star=n_star,
        n_star_paper=n_star_paper,
        most_real_runs=5,
        least=-2.0,
        median=0.0,
        best=tuple(-2.0 + 2.0 * share for share in regret),
        regret=regret,
        cost=tuple(1.4 + number for number in range(len(seconds) + 1)),
        seconds=seconds,
        seconds_before=1.5,
        twin_runs=4,
        corrected_runs=0,
        version="0.1.0",
        alarms=alarms,
    )
