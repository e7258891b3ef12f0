"""A program as the plant: arguments, time-out, exit status, retries, and what it leaves behind."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path

import pytest

from gmfbo.errors import StudyFileError
from gmfbo.recordings.recording import Recording, Trajectory
from gmfbo.sources.plants.plant_command import CommandPlant
from tests.tuning.plants.plant_kinds import BENCH, REFERENCE

GAINS = {"ctl.Kp": 90.0, "ctl.Kd": 4.0}


def plant_of(
    folder: Path, script: str, *, limit: float = 30.0, retries: int = 0, more: tuple[str, ...] = ()
) -> CommandPlant:
    (folder / "script.py").write_text(script, encoding="utf-8")
    command = (sys.executable, "script.py", *more)
    return CommandPlant(command, folder, time_limit_s=limit, retries=retries)


def failure_of(plant: CommandPlant) -> Trajectory:
    run = plant.run(GAINS, REFERENCE)
    assert isinstance(run, Trajectory)
    assert run.status != "ok"
    return run


def test_same_gains_give_the_same_recording(tmp_path: Path) -> None:
    plant = CommandPlant((sys.executable, str(BENCH)), tmp_path)
    one, two = plant.run(GAINS, REFERENCE), plant.run(GAINS, REFERENCE)
    assert dict(one.parameters) == GAINS
    assert one.signal("position").tolist() == two.signal("position").tolist()
    assert one.units["position"] == "rad"


def test_arguments_reach_the_program_as_they_are(tmp_path: Path) -> None:
    odd = ("a b", 'say "hi"', "back\\slash\\", "", "%PATH%", "$HOME", "*", "'x'", "&", "ü")
    plant = plant_of(
        tmp_path,
        "import json, sys, pathlib\npathlib.Path('seen.json').write_text(json.dumps(sys.argv[1:]))",
        more=odd,
    )
    plant.run({"'a = b'.K p": 0.1}, REFERENCE)
    seen = json.loads((tmp_path / "seen.json").read_text())
    assert tuple(seen[: len(odd)]) == odd
    assert seen[len(odd) : len(odd) + 2] == ["--set", "'a = b'.K p=0.1"]
    assert seen[len(odd) + 2 :: 2] == ["--request", "--reference", "--out"]


def test_windows_quoting_brings_every_word_back_whole() -> None:
    # The rule that subprocess applies there, read back by the rules of CommandLineToArgvW.
    words = ["C:\\Program Files\\b.exe", 'say "hi"', "end\\", 'quote\\"', "", "a b\\", "x=1"]
    assert _windows_words(subprocess.list2cmdline(words)) == words


def _windows_words(line: str) -> list[str]:
    """Split as the Microsoft C runtime documents it: 2n backslashes and a quote, 2n + 1, n."""
    words, word, quoted, started, slashes = [], "", False, False, 0
    for letter in line:
        if letter == "\\":
            slashes, started = slashes + 1, True
            continue
        if letter == '"':
            word, started = word + "\\" * (slashes // 2), True
            if slashes % 2:
                word += '"'
            else:
                quoted = not quoted
        else:
            word += "\\" * slashes
            if letter == " " and not quoted:
                words += [word] if started else []
                word, started = "", False
            else:
                word, started = word + letter, True
        slashes = 0
    return [*words, word + "\\" * slashes] if started else words


def test_exit_status_and_last_line_of_standard_error_are_the_message(tmp_path: Path) -> None:
    script = "import sys\nprint('noise')\nprint('first\\nencoder  lost\\n', file=sys.stderr)\n"
    run = failure_of(plant_of(tmp_path, script + "sys.exit(7)"))
    assert run.status == "failed"
    assert run.message.endswith("script.py: exit status 7: encoder lost")
    assert "first" not in run.message


@pytest.mark.skipif(sys.platform == "win32", reason="signals are POSIX")
def test_a_program_ended_by_a_signal_is_said_so(tmp_path: Path) -> None:
    run = failure_of(plant_of(tmp_path, "import os\nos.kill(os.getpid(), 9)"))
    assert run.message.endswith("ended by SIGKILL")


def test_a_program_that_leaves_nothing_has_failed(tmp_path: Path) -> None:
    run = failure_of(plant_of(tmp_path, "print('all well')"))
    assert "expected one recording, --out FILE, got none: all well" in run.message


def test_an_unreadable_recording_is_a_failed_run_and_is_kept(tmp_path: Path) -> None:
    script = "import sys\nopen(sys.argv[-1], 'w').write('no table\\n')"
    run = failure_of(plant_of(tmp_path, script))
    folder = Path(run.message.rpartition("what it left is in ")[2])
    assert (folder / "recording.csv").read_text() == "no table\n"


def test_rows_of_a_run_that_failed_are_kept(tmp_path: Path) -> None:
    script = (
        "import sys\n"
        "open(sys.argv[-1], 'w').write('time [s],position [rad]\\n0,0\\n0.1,2\\n0.2,9\\n')\n"
        "sys.exit('left the envelope')"
    )
    run = failure_of(plant_of(tmp_path, script))
    assert run.signal("position").tolist() == [0.0, 2.0, 9.0]
    assert run.stopped_at == 0.2


def test_another_ending_is_read_too(tmp_path: Path) -> None:
    script = (
        "import sys, pathlib, numpy, scipy.io\n"
        "out = pathlib.Path(sys.argv[-1]).with_suffix('.mat')\n"
        "t = numpy.arange(5) * 0.1\n"
        "scipy.io.savemat(out, {'time': t, 'position': 2 * t})"
    )
    run = plant_of(tmp_path, script).run(GAINS, REFERENCE)
    assert not isinstance(run, Trajectory)
    assert run.signal("position")[-1] == pytest.approx(0.8)


@pytest.mark.parametrize(("retries", "succeeds"), [(0, False), (1, False), (2, True), (5, True)])
def test_a_failed_run_is_repeated_as_often_as_said(
    tmp_path: Path, retries: int, succeeds: bool
) -> None:
    script = (
        "import sys, pathlib\n"
        "count = pathlib.Path('count'); n = len(count.read_text()) if count.exists() else 0\n"
        "count.write_text('x' * (n + 1))\n"
        "if n < 2: sys.exit('not yet')\n"
        "open(sys.argv[-1], 'w').write('time [s],position\\n0,0\\n0.1,1\\n')"
    )
    run: Recording = plant_of(tmp_path, script, retries=retries).run(GAINS, REFERENCE)
    assert isinstance(run, Trajectory) is not succeeds
    assert len((tmp_path / "count").read_text()) == min(retries + 1, 3)


def alive(process: int) -> bool:
    try:
        return "State:\tZ" not in Path(f"/proc/{process}/status").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return False


def ends(process: int, within: float) -> bool:
    """Whether a killed process is gone in time [s]; on a busy machine its end takes a while."""
    limit = time.perf_counter() + within
    while alive(process) and time.perf_counter() < limit:
        time.sleep(0.02)
    return not alive(process)


@pytest.mark.skipif(sys.platform == "win32", reason="looks at /proc")
def test_a_run_that_takes_too_long_is_ended_with_all_that_it_started(tmp_path: Path) -> None:
    script = (
        "import os, subprocess, sys, time, signal, pathlib\n"
        "def rest(*_):\n"
        "    pathlib.Path('at_rest').write_text('yes'); sys.exit(1)\n"
        "signal.signal(signal.SIGTERM, rest)\n"
        "child = subprocess.Popen([sys.executable, '-c',\n"
        "    'import signal, time; signal.signal(15, signal.SIG_IGN); time.sleep(60)'])\n"
        "pathlib.Path('child').write_text(str(child.pid))\n"
        "print('waiting for the drive', file=sys.stderr, flush=True)\n"
        "time.sleep(60)"
    )
    began = time.perf_counter()
    run = failure_of(plant_of(tmp_path, script, limit=3.0))
    assert time.perf_counter() - began < 20.0
    assert run.status == "timeout"
    assert run.message.endswith("took longer than time_limit = 3 s: waiting for the drive")
    assert run.seconds >= 3.0
    assert (tmp_path / "at_rest").read_text() == "yes"
    assert ends(int((tmp_path / "child").read_text()), within=10.0)


def test_a_program_that_does_not_exist_is_refused_before_any_run(tmp_path: Path) -> None:
    with pytest.raises(StudyFileError, match=r"command: no program 'no-such-bench' on PATH; give"):
        CommandPlant(("no-such-bench",), tmp_path).check()
    with pytest.raises(StudyFileError, match=r"no program '\./bench\.sh' in .*; give its path"):
        CommandPlant(("./bench.sh",), tmp_path).check()


@pytest.mark.skipif(sys.platform == "win32", reason="a shell script")
def test_a_path_in_the_command_begins_at_the_study(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    script = tmp_path / "bench.sh"
    script.write_text("#!/bin/sh\necho ran in $(basename $PWD) >&2\nexit 4\n", encoding="utf-8")
    script.chmod(0o755)
    monkeypatch.chdir("/")
    run = failure_of(CommandPlant(("./bench.sh",), tmp_path))
    assert run.message.endswith(f"bench.sh: exit status 4: ran in {tmp_path.name}")
