"""What a hostile FMU tries is refused, what an honest one needs is not (Linux)."""

from __future__ import annotations

import errno
import os
import re
import socket
import stat
import subprocess
import sys
from collections.abc import Iterator, Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from gmfbo import FmuTwin, Recording
from gmfbo.cli import main
from gmfbo.errors import InputError
from gmfbo.sources.sandbox import system_calls
from gmfbo.sources.sandbox.enclosure import Enclosure, available, protection
from gmfbo.sources.sandbox.policy import Policy
from tests.sources.conftest import TEST_FMUS
from tests.sources.worker.processes import children, gone_within

if TYPE_CHECKING:
    from tests.sources.conftest import WriteTwin

pytestmark = [
    pytest.mark.skipif(sys.platform != "linux", reason="the sandbox is Linux's"),
]

ROOT = Path(__file__).resolve().parents[3]
HOSTILE = TEST_FMUS / "faults" / "hostile.fmu"
TWIN = """
name = "hostile"
fmu = "FMU"
step = 1e-3
[inputs]
reference = "reference"
[outputs]
outcome = "outcome"
[initial]
"gain" = 1.0
"""
SHORT = Recording(time=1e-3 * np.arange(3.0), signals={"reference": np.zeros(3)})
# Refused by landlock (EACCES; EXDEV for a move between folders), by seccomp (EPERM), by a limit.
REFUSED = {
    "READ_HOME": errno.EACCES,
    "LIST_HOME": errno.EACCES,
    "WRITE_HOME": errno.EACCES,
    "OVERWRITE_HOME": errno.EACCES,
    "TRUNCATE_HOME": errno.EACCES,
    "DELETE_HOME": errno.EACCES,
    "RENAME_HOME": errno.EACCES,
    "LINK_HOME": errno.EXDEV,
    "CHMOD_HOME": errno.EPERM,
    "WRITE_TEMPORARY": errno.EACCES,
    "SHARED_MEMORY_FILE": errno.EACCES,
    "SHARED_MEMORY_SEGMENT": errno.EPERM,
    "MESSAGE_QUEUE": errno.EPERM,
    "TCP": errno.EPERM,
    "UDP": errno.EPERM,
    "TCP6": errno.EPERM,
    "LISTEN": errno.EPERM,
    "LOCAL_SOCKET": errno.EPERM,
    "START_PROGRAM": errno.EPERM,
    "FORK": errno.EPERM,
    "LEAVE_GROUP": errno.EPERM,
    "KILL_GMFBO": errno.EPERM,
    "READ_ENVIRONMENT_OF_GMFBO": errno.EACCES,
    "WRITE_MEMORY_OF_GMFBO": errno.EACCES,
    "TRACE_GMFBO": errno.EPERM,
    "LIMITS_OF_GMFBO": errno.EPERM,
    "SHORTEN_SHARED": errno.EACCES,
    "REMOVE_SHARED": errno.EACCES,
    "LOCK_OF_OWNER": errno.EACCES,
    "LARGE_FILE": errno.EFBIG,
    "MANY_FILES": errno.EMFILE,
    "RAISE_LIMITS": errno.EPERM,
    "NEW_NAMESPACE": errno.EPERM,
    "RING": errno.EPERM,
}
ALLOWED = ("WRITE_OWN", "THREAD", "READ_SYSTEM")
# Shortening the shared file ends gmfbo, and the rest are denied by some machines anyway.
NOT_TRIED_IN_THE_OPEN = {
    "SHORTEN_SHARED",
    "REMOVE_SHARED",
    "LEAVE_GROUP",  # the worker's group is what gmfbo ends
    "TCP6",
    "MANY_FILES",
    "RAISE_LIMITS",
    "TRACE_GMFBO",
    "WRITE_MEMORY_OF_GMFBO",
    "READ_ENVIRONMENT_OF_GMFBO",
    "NEW_NAMESPACE",
    "RING",
    "LINK_HOME",
    "RENAME_HOME",
    "SHARED_MEMORY_FILE",
    "FORK",
}


def attempts() -> dict[str, int]:
    """Names and numbers of the enumeration in hostile.c."""
    text = (ROOT / "fmu_build/faults/hostile.c").read_text(encoding="utf-8")
    body = re.sub(r"/\*.*?\*/", "", text.split("enum {")[1].split("}")[0])
    numbers: dict[str, int] = {}
    following = 0
    for entry in body.split(","):
        name, _, value = entry.partition("=")
        following = int(value) if value else following
        numbers[name.strip()] = following
        following += 1
    return numbers


class Victim:
    """A home, a secret in it, and a server."""

    def __init__(self, home: Path) -> None:
        self.home, self.secret = home, home / "secret.txt"
        self.server = socket.create_server(("127.0.0.1", 0))
        self.server.setblocking(False)
        self.lay_out()

    def lay_out(self) -> None:
        self.secret.write_text("mine")
        self.secret.chmod(0o600)

    def is_untouched(self) -> bool:
        return (
            [path.name for path in self.home.iterdir()] == ["secret.txt"]
            and self.secret.read_text() == "mine"
            and stat.S_IMODE(self.secret.stat().st_mode) == 0o600
        )

    def has_visitor(self) -> bool:
        try:
            self.server.accept()[0].close()
        except BlockingIOError:
            return False
        return True


def tried(names: list[str], folder: Path, policy: str) -> tuple[dict[str, float], Victim]:
    """What each attempt came to, and the victim afterwards."""
    numbers = attempts()
    (folder / "home").mkdir()
    twin_file = folder / "twin.toml"
    twin_file.write_text(TWIN.replace("FMU", str(HOSTILE), 1))
    victim = Victim(folder / "home")
    came_to = {}
    with pytest.MonkeyPatch.context() as patched:
        patched.setenv("HOME", str(victim.home))
        patched.setenv("GMFBO_TEST_PORT", str(victim.server.getsockname()[1]))
        patched.setenv("GMFBO_SANDBOX", policy)
        with FmuTwin(twin_file) as twin:
            for name in names:
                got = twin.run({}, SHORT, parameters={"attempt": numbers[name]})
                assert got.status == "ok", got.message
                came_to[name] = float(got.signal("outcome")[1])
                if policy:
                    victim.lay_out()
    return came_to, victim


Tried = tuple[Mapping[str, float], Victim]


@pytest.fixture(scope="module")
def shut_in(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Tried]:
    """All attempts, in the sandbox as it is by default."""
    if not available().is_whole:
        pytest.skip(f"this kernel has no whole sandbox: {available().missing}")
    came_to, victim = tried([*ALLOWED, *REFUSED], tmp_path_factory.mktemp("in"), "")
    yield came_to, victim
    victim.server.close()


def test_every_attempt_of_the_hostile_fmu_is_judged() -> None:
    assert set(attempts()) == {*REFUSED, *ALLOWED}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_not_the_fmus_is_refused(name: str, shut_in: Tried) -> None:
    assert shut_in[0][name] == -REFUSED[name]


@pytest.mark.parametrize("name", ALLOWED)
def test_what_an_honest_fmu_needs_is_allowed(name: str, shut_in: Tried) -> None:
    assert shut_in[0][name] == 1.0


def test_the_victim_is_as_before(shut_in: Tried) -> None:
    victim = shut_in[1]
    assert victim.is_untouched()
    assert not victim.has_visitor()
    assert not Path("/dev/shm/gmfbo-hostile").exists()
    assert not Path("/tmp/gmfbo-hostile.txt").exists()


def test_negative_control_without_the_sandbox_the_same_attempts_succeed(tmp_path: Path) -> None:
    names = [name for name in REFUSED if name not in NOT_TRIED_IN_THE_OPEN]
    came_to, victim = tried(names, tmp_path, "off")
    assert came_to == dict.fromkeys(names, 1.0)
    assert victim.has_visitor()
    victim.server.close()


def test_what_an_fmu_starts_and_forgets_ends_with_its_worker(
    tmp_path: Path, own_temporary_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without the sandbox it may start processes, even in a session of their own."""
    monkeypatch.setenv("GMFBO_SANDBOX", "off")
    twin_file = tmp_path / "twin.toml"
    twin_file.write_text(TWIN.replace("FMU", str(HOSTILE), 1))
    with FmuTwin(twin_file) as twin:
        twin.run({}, SHORT, parameters={"attempt": attempts()["FORK"]})
        (keeper,) = children()
        (worker,) = children(keeper)
        left = children(worker)
        assert len(left) == 1
    assert gone_within([worker, *left], 5.0)
    assert children() == []


def test_a_worker_has_its_limits_and_a_new_share_of_processor_time_each_run(
    write_twin: WriteTwin, monkeypatch: pytest.MonkeyPatch, own_temporary_folder: Path
) -> None:
    monkeypatch.setenv("GMFBO_SANDBOX", "memory=2")
    with FmuTwin(write_twin(TWIN, HOSTILE), time_limit_s=7.0) as twin:
        twin.run({}, SHORT)
        (worker,) = children(children()[0])
        lines = Path(f"/proc/{worker}/limits").read_text().splitlines()
    limits = {line[:26].strip(): line[26:].split()[:2] for line in lines}
    assert limits["Max data size"] == ["2000000000", "2000000000"]
    assert limits["Max file size"] == [str(2**30)] * 2
    assert limits["Max open files"] == ["512", "512"]
    assert limits["Max core file size"] == ["0", "0"]
    share = 7.0 * (os.cpu_count() or 1)
    assert share <= int(limits["Max cpu time"][0]) < share + 30.0


def test_processor_time_beyond_the_limit_ends_a_process_with_a_reason() -> None:
    from gmfbo.sources.fmu_file.job import Stage
    from gmfbo.sources.worker.post_mortem import WhereItStood, crash_message

    script = (
        "from gmfbo.sources.sandbox.limits import *; forgo_dumps(); limit_processor_time(0.0)\n"
        "while True: pass"
    )
    done = subprocess.run([sys.executable, "-c", script], timeout=60.0, capture_output=True)
    where = WhereItStood(["x.fmu"], Stage.STEP, 0, 0.1, "", Policy(), 0)
    assert crash_message(where, done.returncode) == (
        "'x.fmu' crashed (SIGXCPU) while stepping after t = 0.1 s; it used more processor time "
        "than its time limit on all cores; raise time_limit in the twin file if it is slow"
    )


def test_the_user_lets_an_fmu_have_network_and_a_folder(tmp_path: Path) -> None:
    (tmp_path / "allowed").mkdir()
    policy = f"network,read={tmp_path}"
    names = ["TCP", "UDP", "READ_HOME", "LIST_HOME", "WRITE_HOME", "FORK"]
    came_to, victim = tried(names, tmp_path / "allowed", policy)
    victim.server.close()
    if available().is_whole:
        done = dict.fromkeys(["TCP", "UDP", "READ_HOME", "LIST_HOME"], 1.0)
        assert came_to == {**done, "WRITE_HOME": -errno.EACCES, "FORK": -errno.EPERM}


@pytest.mark.parametrize(
    ("text", "policy"),
    [
        ("", Policy()),
        ("on", Policy()),
        ("off", Policy(enclosed=False)),
        ("network, memory=2", Policy(network=True, memory=2_000_000_000)),
        ("read=/usr,read=/opt", Policy(read=("/usr", "/opt"))),
    ],
)
def test_the_environment_says_what_an_fmu_may_have(text: str, policy: Policy) -> None:
    assert Policy.from_environment({"GMFBO_SANDBOX": text}) == policy
    assert Policy.from_json(policy.as_dict()) == policy


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("of", r"GMFBO_SANDBOX: expected 'off', or any of 'network', .*; got 'of'"),
        ("read=/no/such", r"GMFBO_SANDBOX: no file or folder '/no/such'; check read="),
        ("memory=lots", r"GMFBO_SANDBOX: expected memory = at least 0\.1 GB, got 'lots'"),
        ("memory=nan", r"GMFBO_SANDBOX: expected memory = at least 0\.1 GB, got 'nan'"),
    ],
)
def test_a_wrong_word_is_one_line(text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Policy.from_environment({"GMFBO_SANDBOX": text})


def test_a_kernel_without_sandbox_is_told_in_words() -> None:
    nothing = Enclosure(0, False)
    assert not nothing.is_whole
    assert "it can read and write your files (the kernel has no landlock)" in nothing.missing
    assert "it can use the network and start programs" in nothing.missing
    assert "the network but TCP" in Enclosure(4, False).missing
    assert Enclosure(2, True).missing == "it can empty your files (landlock 3 is needed)"
    assert Enclosure(3, True).missing == ""


def test_a_run_on_a_kernel_without_landlock_says_so_and_goes_on(
    write_twin: WriteTwin, monkeypatch: pytest.MonkeyPatch, own_temporary_folder: Path
) -> None:
    """The worker finds no landlock: its system call is answered as by an old kernel."""
    from gmfbo.sources.worker import isolation, worker_process

    old = worker_process._START.replace(
        "from gmfbo.sources.worker.keeper",
        "import gmfbo.sources.sandbox.landlock as l; l.version = lambda: 0; "
        "from gmfbo.sources.worker.keeper",
    )
    monkeypatch.setattr(worker_process, "_START", old)
    monkeypatch.setattr(isolation, "_told", False)
    with (
        FmuTwin(write_twin(TWIN, HOSTILE)) as twin,
        pytest.warns(RuntimeWarning, match="runs without the whole sandbox: it can read and wri"),
    ):
        assert twin.run({}, SHORT).status == "ok"


def test_numbers_of_system_calls_are_the_kernels() -> None:
    spec = find_spec("ziglang")
    assert spec is not None
    assert spec.origin is not None
    headers = Path(spec.origin).parent / "lib/libc/include"
    tables = [getattr(system_calls, name) for name in dir(system_calls) if name.isupper()]
    for column, folder in enumerate(("x86-linux-any", "aarch64-linux-any")):
        text = (headers / folder / "asm/unistd_64.h").read_text()
        kernel = {name: int(number) for name, number in re.findall(r"__NR_(\w+)\s+(\d+)", text)}
        for table in tables:
            for name, numbers in table.items():
                assert numbers[column] == kernel.get(name), name


def test_inspect_says_what_protects_the_user(monkeypatch: pytest.MonkeyPatch) -> None:
    lines = protection(Policy())
    assert lines[0].startswith("runs in a process of its own")
    if available().is_whole:
        assert "writes its own temporary folder only" in lines
        assert "has no network" in lines
        assert "starts no program, reaches no other process" in lines
    assert "uses the network" in protection(Policy(network=True))
    assert protection(Policy(enclosed=False))[1] == ("GMFBO_SANDBOX=off: it can do what you can do")


def test_the_command_says_it_too(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def inspect(*options: str, fmu: Path = HOSTILE) -> tuple[int, str, str]:
        status = main(["inspect", str(fmu), *options])
        return status, *capsys.readouterr()

    status, shown, _ = inspect()
    assert status == 0
    told = shown.split("protection when it runs")[1]
    assert all(line in told for line in protection(Policy()))
    assert inspect("--run")[1].endswith("tried: 2 steps of 0.001 s went well\n")
    crash = HOSTILE.with_name("segfault_on_initialise.fmu")
    assert inspect(fmu=crash)[0] == 0
    status, _, said = inspect("--run", fmu=crash)
    assert status == 3
    assert "crashed (SIGSEGV) while initialising; check its" in said
    monkeypatch.setenv("GMFBO_SANDBOX", "of")
    status, _, said = inspect()
    assert status == 2
    assert said.startswith("gmfbo: GMFBO_SANDBOX: expected 'off', or any of")
