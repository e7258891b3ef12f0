"""Campaigns on real schedulers: workers of their own folders, one of them killed half-way."""

from __future__ import annotations

import os
import re
import shutil
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

from gmfbo import Comparison, compare
from gmfbo.cli import main
from gmfbo.studies import cluster as clusters
from tests.studies.small_study import write_small_study
from tests.studies.test_compare import tables

METHODS = ["random", "bo_ei"]
SEEDS, GRID = 3, 5
ROOT = Path(__file__).resolve().parents[2]

NO_COMMON_FILES = """
import os, sys

def refuse(event, arguments):
    if event == "open" and str(arguments[0]).startswith(os.environ["NOT_HERE"]):
        raise PermissionError(f"a worker opened {arguments[0]}")

sys.addaudithook(refuse)
"""


@pytest.fixture(scope="module")
def serial(tmp_path_factory: pytest.TempPathFactory) -> Comparison:
    """All runs in this process."""
    folder = tmp_path_factory.mktemp("serial")
    return compare(write_study(folder), METHODS, SEEDS, grid=GRID, out=folder / "out")


def write_study(folder: Path) -> Path:
    """The small study with twins of its own, which no worker may read."""
    study = write_small_study(folder)
    text = study.read_text(encoding="utf-8")
    (twin,) = set(re.findall(r'twin = "(.*)"', text))
    for name in ("linear_axis.toml", "linear_axis.fmu"):
        shutil.copy(Path(twin).with_name(name), folder / name)
    study.write_text(text.replace(twin, "linear_axis.toml"), encoding="utf-8")
    return study


class Cluster:
    """A dask scheduler and two workers, each a process in a folder of its own."""

    def __init__(self, folder: Path, forbidden: Path) -> None:
        hook = folder / "hook"
        hook.mkdir()
        (hook / "sitecustomize.py").write_text(NO_COMMON_FILES, encoding="utf-8")
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        self.address = f"tcp://127.0.0.1:{port}"
        self._folder, self._path = folder, os.pathsep.join([str(hook), str(ROOT)])
        self._forbidden = forbidden
        self.processes = [
            self._start("scheduler", "--host", "127.0.0.1", "--port", str(port), "--no-dashboard")
        ]
        for name in ("one", "two"):
            options = ("--no-nanny", "--nthreads", "1", "--name", name, "--no-dashboard")
            self.processes.append(self._start("worker", self.address, *options))

    def _start(self, *command: str) -> subprocess.Popen[bytes]:
        place = self._folder / f"{command[0]}-{len(list(self._folder.iterdir()))}"
        place.mkdir()
        surroundings = {
            **os.environ,
            "PYTHONPATH": self._path,
            "NOT_HERE": str(self._forbidden),
            "TMPDIR": str(place),
        }
        with (place / "log.txt").open("wb") as log:
            return subprocess.Popen(
                [sys.executable, "-m", "dask", *command],
                cwd=place,
                env=surroundings,
                stdout=log,
                stderr=log,
            )

    def kill_a_worker(self) -> None:
        self.processes[-1].kill()
        self.processes[-1].wait()

    def close(self) -> None:
        for process in self.processes:
            process.kill()
            process.wait()


@contextmanager
def cluster(folder: Path, forbidden: Path) -> Iterator[Cluster]:
    made = Cluster(folder, forbidden)
    try:
        yield made
    finally:
        made.close()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")  # of tornado and distributed, when connections are cut
def test_campaign_on_dask_survives_a_killed_worker_and_comes_to_the_same_tables(
    serial: Comparison, tmp_path: Path
) -> None:
    distributed = pytest.importorskip("distributed", reason="pip install 'gmfbo[dask]'")
    here, workers = tmp_path / "here", tmp_path / "workers"
    here.mkdir()
    workers.mkdir()
    told: list[str] = []
    with ExitStack() as opened:
        dask = opened.enter_context(cluster(workers, here))
        client = opened.enter_context(distributed.Client(dask.address, timeout=60))
        client.wait_for_workers(2, timeout=60)

        def progress(line: str) -> None:
            told.append(line)
            if len(told) == 3:
                dask.kill_a_worker()

        study = write_study(here)
        # Negative control: a worker that tries is found out.
        with pytest.raises(PermissionError, match="a worker opened"):
            client.submit(Path.read_bytes, study).result()
        result = compare(
            study,
            METHODS,
            SEEDS,
            grid=GRID,
            out=here / "out",
            jobs=client.get_executor(pure=False),
            progress=progress,
        )
        assert len(client.scheduler_info()["workers"]) == 1
    assert result.failed == {}
    assert tables(result.text) == tables(serial.text)
    assert sorted((one.method, one.seed) for one in result.outcomes) == sorted(
        (method, seed) for method in METHODS for seed in range(SEEDS)
    )
    assert len(told) == len(set(told)) == 1 + len(METHODS) * SEEDS


@pytest.mark.slow
def test_campaign_by_mpi_comes_to_the_same_tables(serial: Comparison, tmp_path: Path) -> None:
    pytest.importorskip("mpi4py", reason="pip install 'gmfbo[mpi]'")
    beside = Path(sys.executable).parent / "mpiexec"
    launcher = str(beside) if beside.exists() else shutil.which("mpiexec")
    if launcher is None:
        pytest.skip("needs mpiexec, of an MPI library")
    study, out = write_study(tmp_path), tmp_path / "out"
    program = [sys.executable, "-m", "mpi4py.futures", "-m", "gmfbo", "compare", str(study)]
    options = ["--seeds", str(SEEDS), "--methods", ",".join(METHODS), "--grid", str(GRID)]
    done = subprocess.run(
        [launcher, "-n", "3", *program, *options, "--out", str(out), "--executor", "mpi"],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=240,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    text = (out / "table.txt").read_text(encoding="utf-8")
    assert tables(text) == tables(serial.text)


@pytest.mark.parametrize(
    ("name", "status", "says"),
    [
        ("slurm", 2, "executor: expected dask:ADDRESS"),
        ("dask:", 2, "executor: expected dask:ADDRESS"),
        ("dask:tcp://127.0.0.1:9", 3, "no dask scheduler answers at tcp://127.0.0.1:9"),
    ],
)
@pytest.mark.filterwarnings("ignore")  # of tornado and distributed
def test_cluster_that_is_not_there_is_named_in_one_line(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    name: str,
    status: int,
    says: str,
) -> None:
    pytest.importorskip("distributed", reason="pip install 'gmfbo[dask]'")
    monkeypatch.setattr(clusters, "_CONNECT_S", 1.0)
    study = write_small_study(tmp_path)
    assert main(["compare", str(study), "--executor", name]) == status
    told = capfd.readouterr().err
    assert len(told.strip().splitlines()) == 1
    assert says in told
