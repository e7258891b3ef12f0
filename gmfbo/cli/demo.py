"""`gmfbo demo`: tune the embedded twin, then find physics hidden in an axis."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gmfbo.cli.console import console
from gmfbo.cli.manual import Manual
from gmfbo.errors import InputError

# The real axis is the drive twin itself; half of its digital twin's motor map is noise.
# The default method finds better gains, but stores 1800 twin runs for it: three minutes.
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


MANUAL = Manual(
    files={
        "DIR/demo.study/": "the study, of demo.toml; packed in demo.h5",
        "DIR/sealed.json": "what was hidden",
        "DIR/recordings/": "four recordings of the axis",
        "DIR/found/": "report.html, diagnosis.json and augmented.fmu of the diagnosis",
    },
    examples={
        "In the folder gmfbo-demo; a second one goes to gmfbo-demo-2:": "gmfbo demo",
        "Something else hidden:": "gmfbo demo --seed 7 --out demo7",
    },
    see_also=("gmfbo tune", "gmfbo diagnose"),
)


def demo(
    out: Annotated[
        Path, typer.Option(metavar="DIR", help="New folder for all that the demo makes.")
    ] = Path("gmfbo-demo"),
    seed: Annotated[
        int,
        typer.Option(
            min=0, metavar="N", help="Which wrong twin, which initial gains, what is hidden."
        ),
    ] = 0,
    runs: Annotated[
        int, typer.Option(min=3, metavar="N", help="Runs of the real axis while tuning.")
    ] = 5,
) -> None:
    """Tune an embedded drive, then find what is hidden in an axis.

    Under two minutes on two cores. The twin of the drive has 50 % noise in its motor map; what
    the axis has that its twin lacks is drawn from the seed and sealed before the diagnosis.
    """
    folder = _new_folder(out)
    _tune(folder, seed, runs)
    console.print()
    _find(folder, seed)


def _tune(folder: Path, seed: int, runs: int) -> None:
    import json

    from gmfbo.cli.tuning.tune import run_study
    from gmfbo.recordings.store.pack import pack_study
    from gmfbo.sources.fmu_file.models import models_folder
    from gmfbo.tuning.study.study import Study

    twin = json.dumps((models_folder() / "drive_twin.toml").as_posix())
    file = folder / "demo.toml"
    file.write_text(STUDY.format(seed=seed, runs=runs, twin=twin), encoding="utf-8")
    console.print(
        "1. Tuning. A servo joint follows a step of 1 rad. The real axis is a simulated\n"
        "drive; its twin has 50 % noise in the motor's flux map.\n"
        f"Real runs to spend: {runs}."
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


def _find(folder: Path, seed: int) -> None:
    """Hide something in an axis, diagnose its recordings without knowing, then compare."""
    from gmfbo.cli.diagnosis.diagnose import diagnose_and_show
    from gmfbo.cli.hidden.draw import draw
    from gmfbo.cli.hidden.recordings import record
    from gmfbo.cli.hidden.reveal import answer_lines, explained
    from gmfbo.cli.hidden.sealed import seal, unseal
    from gmfbo.sources.fmu_file.models import models_folder

    twin = models_folder() / "servo_axis.toml"
    drawn = draw(seed)
    sealed = seal(drawn, folder / "sealed.json")
    console.print(
        "2. Diagnosis. Another axis has an effect that its twin lacks, or none: drawn\n"
        f"from the seed and sealed in {sealed.path}, of which you see only the hash:\n"
        f"sha256 {sealed.sha256}"
    )
    stored = folder / "recordings"
    stored.mkdir()
    recordings = record(drawn.plant, seed, stored)
    found = folder / "found"
    console.print(f"now runs           gmfbo diagnose {twin} {stored}/run*.csv --out {found}")
    console.print()
    diagnosis = diagnose_and_show(twin, recordings, found)  # the diagnosis gets the files alone
    answer = unseal(sealed)
    console.print()
    console.print(f"The seal is broken, its hash is the same: {sealed.path}")
    for line in answer_lines(answer, diagnosis):
        console.print(line, markup=False)
    console.print(explained(answer, diagnosis), markup=False)
    console.print(f"report             {found / 'report.html'}")


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
