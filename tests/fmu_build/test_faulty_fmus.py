"""The FMUs that fail on purpose do what they say; the deadly ones in a process of their own."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from fmpy import read_model_description, supported_platforms

if TYPE_CHECKING:
    from tests.fmu_build.conftest import NewInstance

STEP = 1e-3
FMUS = Path(__file__).resolve().parents[1] / "fmus"


def test_without_a_fault_it_is_a_gain(new_instance: NewInstance) -> None:
    faulty = new_instance("faulty").start(gain=2.0)
    table = faulty.run({"reference": np.arange(5.0)}, ["position"], STEP)
    np.testing.assert_array_equal(table[1:, 0], 2.0 * np.arange(5.0))


@pytest.mark.parametrize(("fault", "status"), [(5, 2), (6, 3)])
def test_a_step_is_discarded_or_refused_from_the_stated_time(
    new_instance: NewInstance, fault: int, status: int
) -> None:
    faulty = new_instance("faulty").start(fault=fault, at=0.003)
    for k in range(3):
        faulty.step(k * STEP, STEP)
    with pytest.raises(RuntimeError, match=f"status {status}: .*asked for by parameter 'fault'"):
        faulty.step(3 * STEP, STEP)


def test_initialisation_fails_where_asked(new_instance: NewInstance) -> None:
    with pytest.raises(Exception, match="fmi2ExitInitializationMode failed"):
        new_instance("faulty").start(fault=6, stage=1)


def test_outputs_become_nan(new_instance: NewInstance) -> None:
    faulty = new_instance("faulty").start(fault=4, at=0.002)
    table = faulty.run({"reference": np.ones(4)}, ["position"], STEP)
    np.testing.assert_array_equal(np.isnan(table[:, 0]), [False, False, False, True, True])


def test_a_warning_does_not_stop_the_run(new_instance: NewInstance) -> None:
    faulty = new_instance("faulty").start(fault=9, at=0.002)
    faulty.run({"reference": np.ones(4)}, ["position"], STEP)
    assert faulty.messages == ["warning: asked for by parameter 'fault'"] * 2


def test_it_prints_below_python(
    new_instance: NewInstance, capfd: pytest.CaptureFixture[str]
) -> None:
    faulty = new_instance("faulty").start(fault=8)
    faulty.step(0.0, STEP)
    assert capfd.readouterr().out == "faulty prints to standard output\n"


SCRIPT = """
import sys
sys.path.append({root!r})
from pathlib import Path
from tests.fmu_build.fmu_instance import FmuInstance
faulty = FmuInstance(Path({folder!r})).start(fault={fault}, stage={stage})
print("initialised", flush=True)
faulty.step(0.0, 1e-3)
print("survived", flush=True)
"""


def run_alone(folder: Path, fault: int, stage: int, limit_s: float) -> tuple[int, str]:
    root = str(Path(__file__).resolve().parents[2])
    script = SCRIPT.format(root=root, folder=str(folder), fault=fault, stage=stage)
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=limit_s
    )
    return done.returncode, done.stdout


@pytest.mark.parametrize(
    ("fault", "returncode"), [(1, -signal.SIGSEGV), (2, 0), (7, -signal.SIGABRT)]
)
@pytest.mark.skipif(sys.platform == "win32", reason="exit codes of signals are those of POSIX")
def test_a_crash_or_exit_takes_the_process_along(
    unpacked: Callable[[str], Path], fault: int, returncode: int
) -> None:
    assert run_alone(unpacked("faulty"), fault, 2, 60.0) == (returncode, "initialised\n")


def test_a_crash_can_happen_at_initialisation(unpacked: Callable[[str], Path]) -> None:
    returncode, printed = run_alone(unpacked("faulty"), 2, 1, 60.0)
    assert (returncode, printed) == (0, "")


def test_a_hang_does_not_return(unpacked: Callable[[str], Path]) -> None:
    with pytest.raises(subprocess.TimeoutExpired, match=r"timed out after 5\.0 seconds") as caught:
        run_alone(unpacked("faulty"), 3, 2, 5.0)
    assert caught.value.stdout == b"initialised\n"


def test_the_foreign_fmu_has_a_binary_that_nobody_here_can_load() -> None:
    assert supported_platforms(str(FMUS / "no_binary.fmu")) == ["linux32"]


def test_the_model_exchange_fmu_offers_no_co_simulation() -> None:
    description = read_model_description(str(FMUS / "model_exchange.fmu"))
    assert description.coSimulation is None
    assert description.modelExchange is not None
