"""Text of a first study file for a twin, in which each guess is marked."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass


@dataclass(frozen=True)
class FirstStudy:
    """What a first study rests on.

    Attributes
    ----------
    name : str
        Of the study.
    twin : str
        Path of the twin file, from the study file's folder.
    signal : str
        Controlled signal.
    step : float
        Height of the step that is played [unit].
    unit : str
        SI unit of the reference; empty where unknown.
    sample_time : float
        [s] Of the reference.
    horizon : float
        [s] From the step to the end of a run.
    source : str
        Where height and horizon come from.
    """

    name: str
    twin: str
    signal: str
    step: float
    unit: str
    sample_time: float
    horizon: float
    source: str


def first_study_text(study: FirstStudy) -> str:
    """Write a study file for a person at a bench.

    Parameters
    ----------
    study : FirstStudy
        What it rests on.

    Returns
    -------
    str
        TOML that loads, where the twin file has gains.
    """
    twin, unit = json.dumps(study.twin), f"  # [{study.unit}]" if study.unit else ""
    return f"""\
# By gmfbo init. The gains that may move are those of [gains] in {study.twin}.
name = {json.dumps(study.name)}

[is1]                            # the real axis
ask_tell = true                  # you play it: gmfbo ask study.toml, gmfbo tell study.toml LOG
# twin = {twin}             # instead of ask_tell, to rehearse: gmfbo tune study.toml

[is2]                            # its digital twin
twin = {twin}

[reference]                      # guess: {study.source}
step = {study.step!r}{unit}
at = {round(100 * study.sample_time, 9)!r}  # [s]
horizon = {study.horizon!r}  # [s]
sample_time = {study.sample_time!r}  # [s]

[objective]
signal = {json.dumps(study.signal)}

[budget]
is1_runs = 10                    # real runs, the first two included
"""


def round_step(height: float) -> float:
    """Height of a step of one significant digit, which an axis has already gone.

    Parameters
    ----------
    height : float
        [unit] Largest excursion of a recorded reference from its start, 0 or above.

    Returns
    -------
    float
        [unit] At most 1 % above, since samples miss the peak of a reference by a little.
    """
    if height <= 0.0:
        return 0.0
    reach = 1.01 * height
    exponent = math.floor(math.log10(reach))
    return float(f"{math.floor(reach / 10.0**exponent)}e{exponent}")
