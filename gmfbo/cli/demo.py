"""`gmfbo demo`: the main job on the embedded twin."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gmfbo.cli.console import console
from gmfbo.errors import InputError

# The real axis is the drive twin itself; its digital twin has a motor map half of which is noise.
STUDY = """\
name = "demo"
seed = {seed}
method = "gmfbo"

[is1]
twin = {twin}

[is2]
twin = {twin}
parameters = {{ "map.noise" = 0.5, "map.seed" = "seed" }}

[reference]
step = 1.0
at = 0.1
horizon = 1.0

[budget]
initial_is1 = 2
initial_is2 = 10
is1_runs = {runs}
"""


def demo(
    out: Annotated[Path, typer.Option(help="New folder for all that the demo makes.")] = Path(
        "gmfbo-demo"
    ),
    seed: Annotated[int, typer.Option(min=0, help="Which wrong twin, which initial gains.")] = 0,
    runs: Annotated[int, typer.Option(min=3, help="Runs of the real axis.")] = 8,
) -> None:
    """Tune the embedded drive with few real runs and a wrong twin, in under two minutes."""
    import json

    from gmfbo.cli.tune import run_study
    from gmfbo.recordings.pack import pack_study
    from gmfbo.sources.models import models_folder
    from gmfbo.tuning.study import Study

    folder = _new_folder(out)
    twin = json.dumps((models_folder() / "drive_twin.toml").as_posix())
    file = folder / "demo.toml"
    file.write_text(STUDY.format(seed=seed, runs=runs, twin=twin), encoding="utf-8")
    console.print(
        "A servo joint follows a step of 1 rad. The real axis is a simulated drive; its digital\n"
        f"twin has 50 % noise in the motor's flux map. Tuning takes {runs} runs of the real axis."
    )
    study = Study.read(file)
    result = run_study(study, resume=False)
    if result.best is not None:
        first = next(trial for trial in study.trials if trial.source == "IS1")
        console.print(
            f"first real run     objective {first.objective:.4f}, "
            f"rise time {first.metrics['rise_time']:.4f} s"
        )
    packed = folder / "demo.h5"
    pack_study(study.location, packed)
    console.print(f"one packed file    {packed}")


def _new_folder(out: Path) -> Path:
    for number in range(1, 1000):
        folder = out if number == 1 else out.with_name(f"{out.name}-{number}")
        try:
            folder.mkdir(parents=True)
        except FileExistsError:
            continue
        except OSError as error:
            raise InputError(
                f"--out: cannot make the folder '{folder}': {error.strerror}; name another"
            ) from None
        return folder
    raise InputError(f"--out: '{out}' and its 999 successors exist; name another folder")
