"""The program as a person meets it: output, one line for a mistake, exit status."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import pytest

from gmfbo.cli import main
from gmfbo.sources.fmu_file.models import models_folder

FMUS = Path(__file__).resolve().parents[1] / "fmus"
STUDY = """
name = "small"
seed = 1
method = "random"
[is1]
twin = "{axis}"
[is2]
twin = "{axis}"
[gains]
"kp" = [80.0, 240.0]
"kv" = [120.0, 400.0]
[reference]
step = 0.01
at = 0.05
horizon = 0.4
[budget]
initial_is1 = 2
initial_is2 = 4
iterations = 3
[objective]
normalise = 4
"""


@pytest.fixture
def study_file(tmp_path: Path) -> Path:
    path = tmp_path / "small.toml"
    path.write_text(STUDY.format(axis=(models_folder() / "linear_axis.toml").as_posix()))
    return path


def run(*arguments: object) -> int:
    return main([str(argument) for argument in arguments])


def complaint(capsys: pytest.CaptureFixture[str]) -> str:
    """The one line on standard error."""
    text = capsys.readouterr().err
    assert text.count("\n") == 1
    assert text.startswith("gmfbo: ")
    assert "Traceback" not in text
    return text


def faulty_twin(folder: Path, fault: int, stage: int = 2) -> Path:
    path = folder / "faulty.toml"
    path.write_text(
        f'name = "faulty"\nfmu = "{(FMUS / "faulty.fmu").as_posix()}"\nstep = 0.01\n[inputs]\n'
        f'reference = "reference"\n[outputs]\nposition = "position"\n[parameters]\n'
        f"fault = {fault}\nstage = {stage}\n"
        "at = 0.05\n[gains]\n"
    )
    return path


def test_help_lists_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("--help") == 0
    shown = capsys.readouterr().out
    for command in ("demo", "inspect", "simulate", "tune", "methods", "export", "build"):
        assert command in shown


def test_inspect_prints_variables_with_units(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("inspect", models_folder() / "linear_axis.fmu") == 0
    shown = capsys.readouterr().out
    assert "mass [kg] = 95.1089" in shown
    assert "findings: none" in shown


def test_inspect_writes_a_twin_file_that_simulates(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    fmu = tmp_path / "linear_axis.fmu"
    fmu.write_bytes((models_folder() / "linear_axis.fmu").read_bytes())
    assert run("inspect", "--twin-file", fmu) == 0
    twin = tmp_path / "axis.toml"
    twin.write_text(capsys.readouterr().out)
    assert run("simulate", twin, "--out", tmp_path / "run.csv") == 0


def test_inspect_names_what_keeps_an_fmu_from_running(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("inspect", FMUS / "no_binary.fmu") == 0
    assert "runs here: no" in capsys.readouterr().out


def test_simulating_its_own_output_gives_no_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    twin = models_folder() / "linear_axis.toml"
    first = tmp_path / "first.csv"
    assert run("simulate", twin, "--set", "kp=120", "--out", first) == 0
    capsys.readouterr()
    assert run("simulate", twin, "--reference", first, "--out", tmp_path / "again.h5") == 0
    shown = capsys.readouterr().out
    lines = dict(line.split()[:2] for line in shown.splitlines()[2:])
    assert float(lines["position"]) < 1e-9


def test_tune_keeps_a_study_and_packs_it(
    study_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("tune", study_file) == 0
    assert "best observed" in capsys.readouterr().out
    folder = study_file.with_name("small.study")
    packed = study_file.with_name("small.h5")
    assert run("export", folder, "--pack", packed) == 0
    with h5py.File(packed) as file:
        sources = [file["trials"][name].attrs["source"] for name in file["trials"]]
    assert sources.count("IS1") == 5
    assert sources.count("IS2") >= 4


def test_a_finished_study_is_not_begun_again_by_mistake(
    study_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("tune", study_file) == 0
    capsys.readouterr()
    assert run("tune", study_file) == 2
    assert "go on with them by --resume, or give another" in complaint(capsys)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("inspect", "missing.fmu"), "no FMU at"),
        (("inspect", "pyproject.toml"), "zip"),
        (("simulate", "missing.toml", "--out", "x.csv"), "no twin file"),
        (("simulate", "models/linear_axis.toml", "--out", "x.txt"), ".csv, .h5 or .html"),
        (("simulate", "models/linear_axis.toml", "--set", "kp", "--out", "x.csv"), "NAME=VALUE"),
        (("simulate", "models/linear_axis.toml", "--set", "Kp=1", "--out", "x.csv"), "mean 'kp'"),
        (("simulate", "models/linear_axis.toml", "--out", "no/folder/x.csv"), "folder"),
        (("tune", "missing.toml"), "missing.toml"),
        (("export", "missing.study", "--pack", "x.h5"), "missing.study"),
        (("bogus",), "bogus"),
        (("build", "--compiler", "gcc"), "'zig' or 'system'"),
    ],
)
def test_a_mistake_gets_one_line_and_status_two(
    arguments: tuple[str, ...],
    said: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(Path(__file__).parents[2])
    assert run(*arguments) == 2
    assert said in complaint(capsys)


@pytest.mark.parametrize(
    ("fmu", "said"), [("no_binary", "no binary for this machine"), ("model_exchange", "co-sim")]
)
def test_an_fmu_that_cannot_run_here_is_refused_with_a_cure(
    fmu: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    twin = tmp_path / "twin.toml"
    twin.write_text(
        f'name = "x"\nfmu = "{(FMUS / fmu).as_posix()}.fmu"\nstep = 0.01\n[inputs]\n'
        '[outputs]\ny = "position"\n[gains]\n'
    )
    assert run("simulate", twin, "--out", tmp_path / "x.csv") == 2
    assert said in complaint(capsys)


@pytest.mark.parametrize("fault", [1, 2, 4, 6, 7])
def test_an_fmu_that_fails_gives_status_three_and_keeps_the_rows(
    fault: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "run.csv"
    status = run("simulate", faulty_twin(tmp_path, fault), "--out", out)
    assert status == 3
    assert "faulty" in complaint(capsys)


LOST_INTERRUPT = """
import signal
import weakref


class Held:
    pass


def lost(run):
    held = Held()
    watched = weakref.ref(held, lambda _: signal.raise_signal(signal.SIGINT))
    del held  # what its callback raises is dropped by Python
    return 1.0
"""


def test_an_interrupt_that_python_drops_ends_the_study_all_the_same(study_file: Path) -> None:
    study_file.with_name("mine.py").write_text(LOST_INTERRUPT)
    study_file.write_text(study_file.read_text() + 'metrics = "mine.py:lost"\n')
    program = [sys.executable, "-m", "gmfbo", "tune", str(study_file)]
    tuned = subprocess.run(program, capture_output=True, text=True, timeout=60, check=False)
    assert tuned.stderr.strip() == "gmfbo: interrupted; all finished work is kept"
    assert tuned.returncode == 130
    assert list((study_file.with_name("small.study") / "trials").glob("*.h5"))


def test_an_interrupted_study_keeps_its_runs_and_resumes(
    study_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    study_file.write_text(study_file.read_text().replace("iterations = 3", "iterations = 400"))
    program = [sys.executable, "-m", "gmfbo", "tune", str(study_file)]
    trials = study_file.with_name("small.study") / "trials"
    pipe = subprocess.PIPE
    with subprocess.Popen(program, text=True, stdout=pipe, stderr=pipe) as process:
        try:
            deadline = time.monotonic() + 60.0
            while len(list(trials.glob("*.h5"))) < 8 and time.monotonic() < deadline:
                time.sleep(0.05)
            process.send_signal(signal.SIGINT)
            shown, said = process.communicate(timeout=60)
        finally:
            process.kill()
    assert process.returncode == 130
    assert said.strip() == "gmfbo: interrupted; all finished work is kept"
    assert f"'gmfbo tune {study_file} --resume' goes on with it" in shown
    kept = len(list(trials.glob("*.h5")))
    study_file.write_text(
        study_file.read_text().replace("iterations = 400", f"iterations = {kept}")
    )
    assert main(["tune", str(study_file), "--resume"]) == 0
    resumed = capsys.readouterr().out
    assert "--resume" not in resumed, "a study that has ended is not gone on with"
    assert len(list(trials.glob("*.h5"))) >= kept


def test_too_little_memory_is_one_line_and_no_fault_of_ours(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fill(*arguments: object, **options: object) -> None:
        raise MemoryError

    monkeypatch.setattr("gmfbo.cli.application.app", fill)
    assert main(["check", "axis.toml", "day.csv"]) == 2
    said = capsys.readouterr().err
    assert said.startswith("gmfbo: this takes more memory than there is")
    assert said.count("\n") == 1
