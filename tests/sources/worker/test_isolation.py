"""An FMU that crashes, exits or hangs costs one run, in one line, and leaves nothing behind."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import threading
import time
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from gmfbo import FmuTwin, Recording, step_reference
from gmfbo.errors import FmuFileError
from gmfbo.sources.fmu_file.job import Stage
from gmfbo.sources.worker import isolation
from tests.sources.conftest import AXIS, FAULTY, LOOP, TEST_FMUS
from tests.sources.worker.processes import (
    children,
    descendants,
    gone_within,
    is_stopped,
    open_files,
)

if TYPE_CHECKING:
    from tests.sources.conftest import Repack, WriteTwin

pytestmark = [
    pytest.mark.skipif(not Path("/proc/self").exists(), reason="looks at processes"),
    pytest.mark.usefixtures("own_temporary_folder"),
]

REFERENCE = step_reference(0.01, at=0.05, horizon=0.2, unit="m")
ROWS = np.arange(101, dtype=np.float64)
RAMP = Recording(time=1e-3 * ROWS, signals={"reference": 0.01 * ROWS})


def test_a_worker_gives_the_bits_of_a_run_in_this_process(axis: Path) -> None:
    with FmuTwin(axis) as isolated, FmuTwin(axis, isolated=False) as here:
        for gains in ((160.0, 243.0), (40.0, 60.0), (320.0, 500.0)):
            one, other = isolated.run(gains, REFERENCE), here.run(gains, REFERENCE)
            for name in one.signals:
                assert one.signals[name].tobytes() == other.signals[name].tobytes()
            assert one.status == other.status == "ok"
    assert children() == []


@pytest.mark.parametrize(
    ("fault", "stage", "status", "message"),
    [
        (1, 2, "crashed", "'faulty.fmu' crashed (SIGSEGV) while stepping after t = 0.05 s; try"),
        (1, 1, "crashed", "'faulty.fmu' crashed (SIGSEGV) while initialising; check its param"),
        (2, 2, "crashed", "'faulty.fmu' ended its process with exit code 0 while stepping after"),
        (2, 1, "crashed", "ended its process with exit code 0 while initialising; check"),
        (7, 2, "crashed", "'faulty.fmu' crashed (SIGABRT) while stepping after t = 0.05 s"),
        (4, 2, "diverged", "'faulty.fmu' diverged: an output is not finite at t = 0.051 s"),
        (5, 2, "failed", "refused fmi2DoStep with 'discard': discard: asked for by parameter"),
        (6, 2, "failed", "refused fmi2DoStep with 'error': asked for by parameter 'fault' at t"),
        (6, 1, "failed", "refused fmi2ExitInitializationMode with 'error': asked for by para"),
    ],
)
def test_each_failure_is_a_result_and_the_next_run_is_well(
    fault: int, stage: int, status: str, message: str, faulty: Path
) -> None:
    with FmuTwin(faulty) as twin:
        failed = twin.run({}, RAMP, parameters={"fault": fault, "stage": stage, "at": 0.05})
        assert failed.status == status
        assert message in failed.message
        assert "\n" not in failed.message
        reached = 51 if stage == 2 else 1
        assert len(failed) == reached
        assert failed.stopped_at == pytest.approx(0.05 if stage == 2 else 0.0)
        if stage == 2:
            assert np.isfinite(failed.signal("position")).all()
            assert failed.signal("position")[50] == RAMP.signal("reference")[49]
        well = twin.run({}, RAMP)
        assert well.status == "ok"
        assert well.message == ""
    assert children() == []


@pytest.mark.parametrize("stage", [1, 2])
def test_a_hang_ends_at_the_limit_and_the_next_run_is_well(stage: int, faulty: Path) -> None:
    with FmuTwin(faulty, time_limit_s=0.5) as twin:
        twin.run({}, RAMP)
        started = time.monotonic()
        failed = twin.run({}, RAMP, parameters={"fault": 3, "stage": stage, "at": 0.05})
        assert time.monotonic() - started < 5.0
        assert failed.status == "timeout"
        where = (
            "stepping after t = 0.05 s (fmi2DoStep, or setting or reading values)"
            if stage == 2
            else "initialising (between fmi2SetupExperiment and fmi2ExitInitializationMode)"
        )
        assert failed.message == (
            f"'faulty.fmu' did not finish within 0.5 s, stopped while {where}; raise time_limit "
            "in the twin file if it is slow, else it hangs there"
        )
        assert len(failed) == (51 if stage == 2 else 1)
        assert twin.run({}, RAMP).status == "ok"
    assert children() == []


def test_what_an_fmu_prints_stays_out_of_the_answers(
    faulty: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    with FmuTwin(faulty) as twin:
        assert twin.run({}, RAMP, parameters={"fault": 8}).status == "ok"
        assert twin.run({}, RAMP).status == "ok"
    assert capfd.readouterr() == ("", "")


def test_the_last_words_of_a_crashed_fmu_are_quoted(faulty: Path) -> None:
    with FmuTwin(faulty) as twin:
        twin.run({}, RAMP, parameters={"fault": 8})
        crashed = twin.run({}, RAMP, parameters={"fault": 1})
        assert "it printed last: '" in crashed.message
        assert "faulty prints to standard output'" in crashed.message
        assert "\n" not in crashed.message


def test_a_warning_of_an_fmu_is_told_once_a_run(faulty: Path) -> None:
    with (
        FmuTwin(faulty) as twin,
        pytest.warns(RuntimeWarning, match="faulty: the FMU answered 100 calls with a warning"),
    ):
        assert twin.run({}, RAMP, parameters={"fault": 9}).status == "ok"


def test_a_worker_killed_between_runs_is_replaced_without_a_word(axis: Path) -> None:
    with FmuTwin(axis) as twin:
        before = twin.run({}, REFERENCE)
        (worker,) = children()
        os.killpg(worker, signal.SIGKILL)
        after = twin.run({}, REFERENCE)
        assert after.status == "ok"
        assert after.signal("position").tobytes() == before.signal("position").tobytes()
        assert children() != [worker]
    assert children() == []


def test_a_worker_killed_just_after_its_answer_is_replaced_without_a_word(axis: Path) -> None:
    """It had not yet said that it frees instances; that is no sign of closed files."""
    with FmuTwin(axis) as twin:
        twin.run({}, REFERENCE)
        runner: Any = twin._runner
        os.killpg(children()[0], signal.SIGKILL)
        runner._arrays.progress[:] = (Stage.ANSWER, 0)
        assert twin.run({}, REFERENCE).status == "ok"


def test_a_worker_whose_keeper_is_killed_ends_with_it(faulty: Path) -> None:
    with FmuTwin(faulty) as twin:
        twin.run({}, RAMP)
        keeper, worker = descendants(os.getpid())
        threading.Timer(0.3, os.kill, (keeper, signal.SIGKILL)).start()
        killed = twin.run({}, RAMP, parameters={"fault": 3, "at": 0.05})
        assert killed.status == "crashed"
        assert gone_within([worker], 5.0)
        assert twin.run({}, RAMP).status == "ok"
    assert children() == []


def test_a_run_shares_memory_in_its_own_folder_only(axis: Path, own_temporary_folder: Path) -> None:
    """So nothing can be left in /dev/shm, nor a segment that only a restart removes."""
    with FmuTwin(axis) as twin:
        twin.run({}, REFERENCE)
        for process in descendants(os.getpid()):
            maps = Path(f"/proc/{process}/maps").read_text().splitlines()
            shared = {line.split()[-1] for line in maps if line.split()[1] == "rw-s"}
            assert all(path.startswith(str(own_temporary_folder)) for path in shared), shared


def test_an_fmu_in_this_process_leaves_the_working_folder_as_it_was(
    write_twin: WriteTwin,
) -> None:
    before = Path.cwd()
    text = FAULTY.replace("faulty", "changes_folder")
    with FmuTwin(write_twin(text, TEST_FMUS / "faults/changes_folder.fmu"), isolated=False) as twin:
        assert twin.run({}, RAMP).status == "ok"
        assert Path.cwd() == before


def test_a_worker_killed_in_a_run_is_a_crashed_run(faulty: Path) -> None:
    with FmuTwin(faulty) as twin:
        twin.run({}, RAMP)
        (worker,) = children()
        threading.Timer(0.3, os.kill, (worker, signal.SIGKILL)).start()
        killed = twin.run({}, RAMP, parameters={"fault": 3, "at": 0.05})
        assert killed.status == "crashed"
        assert "'faulty.fmu' crashed (SIGKILL) while stepping after t = 0.05 s" in killed.message
        assert twin.run({}, RAMP).status == "ok"


# A test run under nohup passes on that a hangup is ignored; the child is to die of it.
CHILD = """
import signal, sys
signal.signal(signal.SIGHUP, signal.SIG_DFL)
from gmfbo import FmuTwin, Recording
import numpy as np
ramp = Recording(time=1e-3 * np.arange(101), signals={"reference": np.arange(101.0)})
twin = FmuTwin(sys.argv[1])
twin.run({}, ramp)
print("ready", flush=True)
ENDING
"""


def child(ending: str, twin: Path) -> subprocess.Popen[str]:
    process = subprocess.Popen(
        [sys.executable, "-c", CHILD.replace("ENDING", ending), str(twin)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    return process


@pytest.mark.parametrize(
    "ending",
    [
        pytest.param("sys.stdin.read()", id="idle"),
        pytest.param("twin.run({}, ramp, parameters={'fault': 3})", id="in a hanging run"),
    ],
)
@pytest.mark.parametrize("way", [signal.SIGKILL, signal.SIGTERM, signal.SIGHUP])
def test_nothing_is_left_when_the_parent_is_killed(
    ending: str, way: signal.Signals, faulty: Path, own_temporary_folder: Path
) -> None:
    with child(ending, faulty) as parent:
        time.sleep(0.2)
        keeper_and_worker = descendants(parent.pid)
        assert len(keeper_and_worker) == 2
        assert len(list(own_temporary_folder.iterdir())) == 1
        parent.send_signal(way)
        parent.communicate()
        assert parent.returncode == -way
    assert gone_within(keeper_and_worker, 5.0)


@pytest.mark.parametrize(
    ("ending", "code"),
    [
        ("pass", 0),
        ("sys.exit(3)", 3),
        ("raise ValueError", 1),
        ("del twin", 0),
        ("here = FmuTwin(sys.argv[1], isolated=False); here.run({}, ramp)", 0),
    ],
)
def test_nothing_is_left_when_a_script_forgets_to_close(
    ending: str, code: int, faulty: Path
) -> None:
    with child(ending, faulty) as parent:
        workers = descendants(parent.pid)
        _, complaints = parent.communicate(timeout=20)
        assert parent.returncode == code
    assert gone_within(workers, 5.0)
    assert "ResourceWarning" not in complaints


def test_nothing_is_left_when_the_user_interrupts(faulty: Path) -> None:
    with child("twin.run({}, ramp, parameters={'fault': 3})", faulty) as parent:
        time.sleep(0.2)
        workers = descendants(parent.pid)
        os.killpg(parent.pid, signal.SIGINT)  # as a terminal does: the worker gets it too
        _, complaints = parent.communicate(timeout=20)
        assert parent.returncode != 0
        assert "KeyboardInterrupt" in complaints
    assert gone_within(workers, 5.0)


def test_a_folder_of_a_parent_and_worker_killed_together_is_removed_later(
    axis: Path, own_temporary_folder: Path
) -> None:
    with child("sys.stdin.read()", axis) as parent:
        keeper, worker = descendants(parent.pid)
        os.kill(keeper, signal.SIGSTOP)
        while not is_stopped(keeper):  # a stop takes its time on a busy machine
            time.sleep(0.001)
        parent.kill()
        os.kill(keeper, signal.SIGKILL)
        parent.communicate()
    assert gone_within([keeper, worker], 5.0)
    (left,) = own_temporary_folder.iterdir()
    with FmuTwin(axis) as twin:
        twin.run({}, REFERENCE)
        assert left.exists()  # young folders are let be: their owner may be about to lock them
    os.utime(left, (0.0, 0.0))
    with FmuTwin(axis) as twin:
        twin.run({}, REFERENCE)
        assert not left.exists()


def test_a_folder_that_is_in_use_is_never_removed(axis: Path, own_temporary_folder: Path) -> None:
    with FmuTwin(axis) as first:
        first.run({}, REFERENCE)
        (used,) = own_temporary_folder.iterdir()
        os.utime(used, (0.0, 0.0))
        with FmuTwin(axis) as second:
            second.run({}, REFERENCE)
            assert used.exists()
        assert first.run({}, REFERENCE).status == "ok"


def test_two_twins_run_at_once_and_apart(axis: Path) -> None:
    with FmuTwin(axis) as one, FmuTwin(axis) as two:
        expected = one.run((160.0, 243.0), REFERENCE).signal("position")
        got: dict[str, bytes] = {}

        def repeat(name: str, twin: FmuTwin) -> None:
            for _ in range(20):
                got[name] = twin.run((160.0, 243.0), REFERENCE).signal("position").tobytes()

        threads = [threading.Thread(target=repeat, args=a) for a in (("1", one), ("2", two))]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert got == {"1": expected.tobytes(), "2": expected.tobytes()}


def test_many_runs_open_no_more_files_and_no_more_threads(axis: Path) -> None:
    with FmuTwin(axis) as twin:
        twin.run({}, REFERENCE)
        files, threads = open_files(os.getpid()), threading.active_count()
        keeper, worker = descendants(os.getpid())
        worker_files = open_files(worker)
        for _ in range(200):
            twin.run({}, REFERENCE)
        assert open_files(os.getpid()) == files
        assert open_files(worker) == worker_files
        assert threading.active_count() == threads
        assert descendants(os.getpid()) == [keeper, worker]


def test_crashes_leave_no_open_files_and_no_zombies(faulty: Path) -> None:
    with FmuTwin(faulty) as twin:
        twin.run({}, RAMP)
        files = open_files(os.getpid())
        for _ in range(5):
            assert twin.run({}, RAMP, parameters={"fault": 1}).status == "crashed"
        assert children() == []
        twin.run({}, RAMP)
        assert open_files(os.getpid()) == files


def test_a_longer_run_gets_more_room(axis: Path) -> None:
    long = step_reference(0.01, at=0.05, horizon=30.0, unit="m")
    with FmuTwin(axis) as isolated, FmuTwin(axis, isolated=False) as here:
        isolated.run({}, REFERENCE)
        got, expected = isolated.run({}, long), here.run({}, long)
        assert got.signal("position").tobytes() == expected.signal("position").tobytes()


def test_a_worker_whose_memory_grows_is_replaced(
    axis: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(isolation, "_GROWTH_BYTES", -1)
    monkeypatch.setattr(isolation, "_WARM_UP_ANSWERS", 0)
    with FmuTwin(axis) as twin:
        twin.run({}, REFERENCE)
        assert children() == []
        assert twin.run({}, REFERENCE).status == "ok"


def test_a_full_disk_is_one_line(axis: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from gmfbo.errors import SimulationError

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    with FmuTwin(axis) as twin:
        monkeypatch.setattr(os, "posix_fallocate", full)
        with pytest.raises(SimulationError, match=r"cannot reserve .* MB .*No space left on dev"):
            twin.run({}, REFERENCE)


def test_an_fmu_that_allows_one_instance_gets_a_process_for_each(
    repack: Repack, write_twin: WriteTwin, axis: Path
) -> None:
    with FmuTwin(axis) as plain:
        expected = plain.run({}, REFERENCE).signal("position")
    once = 'canBeInstantiatedOnlyOncePerProcess="'
    fmu = repack(edits={once + "false": once + "true"})
    path = write_twin(AXIS, fmu)
    with FmuTwin(path) as twin:
        assert twin.run({}, REFERENCE).signal("position").tobytes() == expected.tobytes()
        assert children() == []
    with pytest.raises(FmuFileError, match="can be instantiated only once in the life of a proc"):
        FmuTwin(path, isolated=False)


def test_of_wired_fmus_all_that_stepped_are_named(write_twin: WriteTwin) -> None:
    text = LOOP.replace("[wires]", f'bad = "{TEST_FMUS / "faulty.fmu"}"\n[wires]')
    with FmuTwin(write_twin(text)) as twin:
        crashed = twin.run({}, RAMP, parameters={"bad.fault": 1})
        assert "one of 'pd_filtered.fmu', 'linear_axis.fmu', 'faulty.fmu' cra" in crashed.message
        failed = twin.run({}, RAMP, parameters={"bad.fault": 6})
        assert "'faulty.fmu' refused fmi2DoStep with 'error'" in failed.message


def test_an_fmu_of_a_loaded_library_that_changed_is_refused(
    repack: Repack, write_twin: WriteTwin
) -> None:
    path = write_twin(AXIS, repack())
    with FmuTwin(path) as twin:
        repack(members={"extra.txt": b"changed"})
        with pytest.raises(FmuFileError, match=r"changed after the twin was opened; open the tw"):
            twin.run({}, REFERENCE)


def test_a_forked_copy_uses_a_worker_of_its_own(axis: Path) -> None:
    with FmuTwin(axis) as twin:
        expected = twin.run({}, REFERENCE).signal("position").tobytes()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # threads and fork
            pid = os.fork()
        if pid == 0:
            same = twin.run({}, REFERENCE).signal("position").tobytes() == expected
            twin.close()
            os._exit(0 if same else 1)
        assert os.waitpid(pid, 0)[1] == 0
        assert twin.run({}, REFERENCE).signal("position").tobytes() == expected


def test_a_closed_twin_starts_anew(axis: Path) -> None:
    twin = FmuTwin(axis)
    first = twin.run({}, REFERENCE)
    twin.close()
    assert children() == []
    assert (
        twin.run({}, REFERENCE).signal("position").tobytes() == first.signal("position").tobytes()
    )
    twin.close()
    twin.close()


def test_modules_of_the_working_folder_do_not_reach_the_worker(
    axis: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "json.py").write_text("raise RuntimeError('not the real one')")
    monkeypatch.chdir(tmp_path)
    with FmuTwin(axis) as twin:
        assert twin.run({}, REFERENCE).status == "ok"


def test_a_twin_without_a_run_starts_no_process(axis: Path, own_temporary_folder: Path) -> None:
    with FmuTwin(axis) as twin:
        assert len(twin.signal_specs()) == 3
        assert children() == []
        assert list(own_temporary_folder.iterdir()) == []


def test_a_pickled_twin_opens_anew(axis: Path) -> None:
    with FmuTwin(axis, parameters={"mass": 80.0}, step=5e-4) as twin:
        expected = twin.run({}, REFERENCE)
        copy = pickle.loads(pickle.dumps(twin))
        with copy:
            assert copy.content_hash == twin.content_hash
            assert np.array_equal(
                copy.run({}, REFERENCE).signal("position"), expected.signal("position")
            )
            assert len(children()) == 2
