"""What each way to fail comes to: a result or one clear error, and the next run is well."""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from fmu_build.fault_fmus import read_faults
from gmfbo import FmuTwin, Recording, Trajectory
from gmfbo.errors import FmuFileError
from gmfbo.objective.metrics import METRICS, step_metrics
from gmfbo.sources.inspection.inspection import inspect_fmu
from gmfbo.sources.worker import isolation
from tests.sources.conftest import FAULTY, TEST_FMUS
from tests.sources.worker.processes import children

if TYPE_CHECKING:
    from tests.sources.conftest import WriteTwin

pytestmark = [
    pytest.mark.skipif(not Path("/proc/self").exists(), reason="looks at processes"),
    pytest.mark.usefixtures("own_temporary_folder"),
]

FAULTS = TEST_FMUS / "faults"
RAMP = Recording(
    time=1e-3 * np.arange(101.0), signals={"reference": 0.01 * np.arange(101, dtype=np.float64)}
)
NEVER = {"at": 10.0}


@dataclass(frozen=True)
class Gets:
    """What a run comes to.

    Attributes
    ----------
    status : str
        Of the trajectory; empty where the file is refused.
    rows : int
        Of the trajectory.
    says : str
        In the message, after the FMU's name.
    warns : str
        In the warning.
    """

    status: str
    rows: int = 101
    says: str = ""
    warns: str = ""


def at_start(status: str, says: str) -> Gets:
    return Gets(status, 1, says)


def in_step(status: str, says: str) -> Gets:
    return Gets(status, 51, says)


VENDOR = "while being instantiated; check that its licence and resources are in place, or ask its"
INITIAL = "while initialising; check its parameters and initial values, or ask its vendor"
OTHER = "while stepping after t = 0.05 s; try other gains or parameters, or ask its vendor"
SLOW = "raise time_limit in the twin file if it is slow, else it hangs there"
SETUP = "between fmi2SetupExperiment and fmi2ExitInitializationMode"
CALL = "fmi2DoStep, or setting or reading values"
ONE_A_PROCESS = "each run gets a process of its own from now on"
GETS = {
    "none": Gets("ok"),
    "segfault_on_load": at_start("crashed", "crashed (SIGSEGV) while being loaded; ask its vendor"),
    "exit_on_load": at_start("crashed", "ended its process with exit code 7 while being loaded; a"),
    "hang_on_load": at_start("timeout", "did not load within 2 s: it hangs there, or waits for a"),
    "segfault_on_instantiate": at_start("crashed", f"crashed (SIGSEGV) {VENDOR}"),
    "exit_on_instantiate": at_start("crashed", f"ended its process with exit code 0 {VENDOR}"),
    "hang_on_instantiate": at_start(
        "timeout", f"stopped while being instantiated (fmi2Instantiate); {SLOW}"
    ),
    "segfault_on_setup": at_start("crashed", f"crashed (SIGSEGV) {INITIAL}"),
    "segfault_on_initialise": at_start("crashed", f"crashed (SIGSEGV) {INITIAL}"),
    "hang_on_initialise": at_start("timeout", f"stopped while initialising ({SETUP}); {SLOW}"),
    "segfault_on_set": at_start("crashed", "crashed (SIGSEGV) while stepping after t = 0 s; try"),
    "segfault_on_get": at_start("crashed", "crashed (SIGSEGV) while stepping; try other gains"),
    "segfault_in_step": in_step("crashed", f"crashed (SIGSEGV) {OTHER}"),
    "abort_in_step": in_step("crashed", f"crashed (SIGABRT) {OTHER}"),
    "exit_in_step": in_step("crashed", f"ended its process with exit code 0 {OTHER}"),
    "hang_in_step": in_step("timeout", f"stopped while stepping after t = 0.05 s ({CALL}); {SLOW}"),
    "segfault_on_free": Gets("ok", warns=f"falls when it is freed: {ONE_A_PROCESS}"),
    "hang_on_free": Gets("ok", warns=f"falls when it is freed: {ONE_A_PROCESS}"),
    "nan": in_step("diverged", "diverged: an output is not finite at t = 0.051 s; the gains or p"),
    "huge": Gets("ok"),
    "discard": in_step(
        "failed",
        "refused fmi2DoStep with 'discard': the step was too long at t = 0.05 s: it ended the "
        "simulation itself; check its limits and end conditions",
    ),
    "discard_without_termination": in_step(
        "failed", "refused fmi2DoStep with 'discard': the step was too long at t = 0.05 s"
    ),
    "warning_each_step": Gets("ok", warns="the FMU answered 50 calls with a warning"),
    "error_at": in_step(
        "failed", "refused fmi2DoStep with 'error': the solver did not converge at t = 0.05 s"
    ),
    "fatal_at": in_step(
        "failed", "refused fmi2DoStep with 'fatal': no instance can go on at t = 0.05 s"
    ),
    "leak_each_instance": Gets("ok"),
    "leak_without_end": Gets("crashed", 0, "it held 0.4"),
    "refuses_second_instance": Gets("ok"),
    "dies_on_second_instance": Gets(
        "ok", warns=f"bears one instance in the life of a process, .* say so: {ONE_A_PROCESS}"
    ),
    "once_per_process": Gets("ok"),
    "reset_does_not_reset": Gets("ok"),
    "fixed_step": Gets("ok"),
    "stop_time_enforced": Gets("ok"),
    "wrong_library_name": Gets("ok"),
    "no_optional_symbols": Gets("ok"),
    "missing_system_library": Gets(
        "",
        says="its library cannot be loaded: it needs the system library libgmfbo_absent.so, which "
        "is not installed; install the package that provides libgmfbo_absent.so",
    ),
    "output_lies": Gets("ok"),
    "leaves_outputs_unwritten": Gets("ok"),
    "prints": Gets("ok"),
    "changes_folder": Gets("ok"),
    "closes_files": Gets("ok", warns="closes files of the process .*: each run gets a fresh one"),
    "writes_into_answers": at_start("crashed", "spoiled the run: it writes to files of the proc"),
    "hostile": Gets("ok"),
}


def twin_of(name: str, write_twin: WriteTwin, **how: float) -> FmuTwin:
    return FmuTwin(write_twin(FAULTY, FAULTS / f"{name}.fmu"), **how)  # type: ignore[arg-type]


def run(twin: FmuTwin, **parameters: float) -> tuple[Trajectory, str]:
    """A run and what it warned of."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        trajectory = twin.run({}, RAMP, parameters=parameters)
    return trajectory, "; ".join(str(warning.message) for warning in caught)


def test_every_fault_fmu_has_an_expectation() -> None:
    assert {fault.name for fault in read_faults()} == set(GETS)
    assert {path.stem for path in FAULTS.glob("*.fmu")} == set(GETS)


@pytest.mark.parametrize("name", GETS)
def test_each_fault_is_a_result_or_one_clear_error(
    name: str, write_twin: WriteTwin, monkeypatch: pytest.MonkeyPatch
) -> None:
    gets = GETS[name]
    monkeypatch.setattr(isolation, "START_LIMIT_S", 2.0 if name == "hang_on_load" else 60.0)
    if name == "leak_without_end":
        monkeypatch.setenv("GMFBO_SANDBOX", "memory=0.5")
    limit_s = 1.0 if name.startswith("hang") else 60.0
    with twin_of(name, write_twin, time_limit_s=limit_s) as twin:
        if not gets.status:
            with pytest.raises(FmuFileError, match=re.escape(f"'{name}.fmu': {gets.says}")):
                twin.run({}, RAMP)
            assert children() == []
            return
        got, warned = run(twin)
        assert got.status == gets.status, got.message
        assert len(got) == gets.rows or not gets.rows
        assert got.message.startswith(f"'{name}.fmu'" if gets.says else "")
        assert gets.says in got.message
        assert "\n" not in got.message
        assert re.search(gets.warns or "^$", warned), warned
        if gets.rows == 51:
            # The rows before the fault are kept, and the study goes on.
            assert np.array_equal(got.signal("position")[1:], RAMP.signal("reference")[:50])
            well, _ = run(twin, **NEVER)
            assert well.status == "ok"
            assert np.array_equal(well.signal("position")[1:], RAMP.signal("reference")[:-1])
    assert children() == []


@pytest.mark.parametrize(
    "name",
    [
        "segfault_on_free",
        "refuses_second_instance",
        "dies_on_second_instance",
        "once_per_process",
        "reset_does_not_reset",
        "stop_time_enforced",
        "changes_folder",
        "closes_files",
        "prints",
    ],
)
def test_run_after_run_is_the_same_and_the_warning_comes_once(
    name: str, write_twin: WriteTwin
) -> None:
    with twin_of(name, write_twin) as twin:
        first, warned = run(twin)
        again, more = run(twin)
        assert again.signal("position").tobytes() == first.signal("position").tobytes()
        assert more == ""
    assert bool(warned) == bool(GETS[name].warns)


def test_a_worker_is_replaced_before_leaks_add_up(
    write_twin: WriteTwin, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(isolation, "_WARM_UP_BYTES", 40 * 2**20)
    with twin_of("leak_each_instance", write_twin) as twin:
        workers = set()
        for _ in range(8):  # 16 MB each: one instance to find rest, one to run
            assert run(twin)[0].status == "ok"
            workers |= set(children())
        assert 2 <= len(workers) <= 4


def test_a_step_that_a_fixed_step_fmu_refuses_is_told_with_the_step_that_it_takes(
    write_twin: WriteTwin,
) -> None:
    with twin_of("fixed_step", write_twin, step=5e-4) as twin:
        got, _ = run(twin)
        assert got.status == "failed"
        assert got.message == (
            "'fixed_step.fmu' refused fmi2DoStep with 'error': the step is fixed at t = 0 s; "
            "'fixed_step.fmu' takes one step only: set step = 0.001 in the twin file"
        )


def test_huge_values_are_a_result_and_a_finite_objective(write_twin: WriteTwin) -> None:
    with twin_of("huge", write_twin) as twin:
        got, _ = run(twin)
        assert got.signal("position").max() == 1e300
        metrics = step_metrics(got.time, got.signal("position"), step_time=0.0, horizon=0.1)
        assert set(metrics) == set(METRICS)
        assert all(np.isfinite(value) for value in metrics.values())


def test_a_lie_shows_against_a_recording_only(write_twin: WriteTwin) -> None:
    """No run can tell; the error against what was measured does."""
    with twin_of("none", write_twin) as honest, twin_of("output_lies", write_twin) as liar:
        truth, told = run(honest)[0], run(liar)[0]
    assert told.status == truth.status == "ok"
    error = told.signal("position") - truth.signal("position")
    assert np.sqrt(np.mean(error**2)) / np.ptp(truth.signal("position")) > 0.01


def test_no_fault_fmu_is_run_by_looking_at_it() -> None:
    for path in sorted(FAULTS.glob("*.fmu")):
        report = inspect_fmu(path)
        assert report.obstacle == ""
        assert report.findings == (), path.name
    assert children() == []
