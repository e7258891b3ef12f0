"""Many simulations through one process that tunes, and what they leave behind (Linux: /proc)."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gmfbo import FmuTwin, Recording, Study, Tuner
from tests.sources.worker.processes import descendants

STUDY = """
method = "random"
[is1]
twin = "{is1}"
[is2]
twin = "{is2}"
[gains]
"controller.kp" = [500.0, 8000.0]
"controller.kd" = [10.0, 150.0]
[reference]
step = 0.01
at = 0.05
horizon = 0.15
[objective]
normalise = 2
[budget]
initial_is1 = 2
initial_is2 = 2
is1_runs = 4
"""
_STEPS = 200


@dataclass(frozen=True)
class Usage:
    """What a process and its workers hold.

    Attributes
    ----------
    runs : int
        Simulations so far.
    tuner, workers : int
        [byte] Resident memory of the process, and of its workers and keepers together.
    open_files : int
        File descriptors of all of them.
    processes : int
        Workers and their keepers.
    """

    runs: int
    tuner: int
    workers: int
    open_files: int
    processes: int

    @property
    def total(self) -> int:
        """[byte] Memory of all processes."""
        return self.tuner + self.workers


def usage(runs: int) -> Usage:
    """Look at this process, its workers and their keepers."""
    own = os.getpid()
    children = descendants(own)
    files = sum(len(list(Path(f"/proc/{pid}/fd").iterdir())) for pid in (own, *children))
    return Usage(runs, _resident(own), sum(map(_resident, children)), files, len(children))


def _resident(pid: int) -> int:
    pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


def simulate_often(
    folder: Path, twins: Sequence[Path], runs: int, looks: int, warm_up: int
) -> Iterator[Usage]:
    """Tune, then simulate with the tuner's own twins in turn while it is open; look now and then.

    Parameters
    ----------
    folder : Path
        For the study.
    twins : sequence of Path
        Twin files; the first two have the same gains, and are those of the study.
    runs : int
        Simulations.
    looks : int
        How often memory and files are read, after the warm-up.
    warm_up : int
        Simulations before the first look.
    """
    study = folder / "long.toml"
    study.write_text(STUDY.format(is1=twins[1].as_posix(), is2=twins[0].as_posix()))
    with ExitStack() as opened:
        open_twins = [opened.enter_context(FmuTwin(path)) for path in twins]
        tuner = Tuner(Study.read(study), is1=open_twins[1], is2=open_twins[0])
        opened.callback(tuner.close)
        tuner.run()
        at = np.unique(np.linspace(warm_up, runs, looks + 1).round().astype(int))
        references = [_reference(twin) for twin in open_twins]
        done = 0
        for stop in at:
            while done < stop:
                turn = done % len(twins)
                run = open_twins[turn].run({}, references[turn])
                if run.status != "ok":
                    raise RuntimeError(f"run {done} of {twins[turn].name}: {run.message}")
                done += 1
            yield usage(done)


def _reference(twin: FmuTwin) -> Recording:
    time = np.arange(_STEPS, dtype=np.float64) * twin.step
    signals = {name: np.where(time > 0.05, 0.01, 0.0) for name in twin.file.inputs}
    return Recording(time=time, signals=signals)
