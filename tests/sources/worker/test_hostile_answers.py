"""Foreign code shares the process that answers: gmfbo believes no answer unseen."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gmfbo import FmuTwin, step_reference
from gmfbo.files.private_folder import PrivateFolder
from gmfbo.sources.worker.answer import read_outcomes
from gmfbo.sources.worker.post_mortem import plain_line
from gmfbo.sources.worker.worker_process import WorkerGarbled, WorkerProcess

if TYPE_CHECKING:
    from collections.abc import Iterator

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="a POSIX shell answers")

GOOD = {"status": "ok", "rows": 3, "message": "", "warnings": 0, "stage": 0}
ANSWERS: list[Any] = [
    {},
    {"outcomes": 3},
    {"outcomes": [None]},
    {"outcomes": [{"status": "ok"}]},
    {"outcomes": [{**GOOD, "status": "splendid"}]},
    {"outcomes": [{**GOOD, "status": []}]},
    {"outcomes": [{**GOOD, "rows": 10**9}]},
    {"outcomes": [{**GOOD, "rows": -1}]},
    {"outcomes": [{**GOOD, "rows": "three"}]},
    {"outcomes": [{**GOOD, "rows": float("inf")}]},
    {"outcomes": [{**GOOD, "warnings": "many"}]},
    {"outcomes": [{**GOOD, "rows": 2}]},
    {"outcomes": [{**GOOD, "stage": 77}]},
    {"outcomes": [{**GOOD, "surprise": 1}]},
]


@pytest.mark.parametrize("answer", ANSWERS, ids=str)
def test_an_answer_that_is_none_is_one_error(answer: Any) -> None:
    assert read_outcomes(answer, [np.zeros((3, 1))]) is None


def test_a_good_answer_is_read() -> None:
    outcomes = read_outcomes({"outcomes": [GOOD]}, [np.zeros((3, 1))])
    assert outcomes is not None
    assert outcomes[0].status == "ok"


@given(
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
        lambda inner: (
            st.lists(inner, max_size=3)
            | st.dictionaries(st.sampled_from([*GOOD, "outcomes"]), inner, max_size=6)
        ),
        max_leaves=12,
    )
)
def test_no_answer_breaks_the_reader(raw: Any) -> None:
    outcomes = read_outcomes({"outcomes": raw}, [np.zeros((3, 1))])
    assert outcomes is None or all(o.rows <= 3 and o.message.isprintable() for o in outcomes)


@given(st.text())
def test_no_control_character_reaches_a_message(text: str) -> None:
    line = plain_line("\x1b[2J" + text)
    assert line.isprintable()
    assert "\x1b" not in line
    assert len(line) <= 2000


class Answering(WorkerProcess):
    """A worker that answers each question with the same bytes."""

    def __init__(self, folder: Path, answer: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
        (folder / "answer").write_bytes(answer)
        script = "import sys, pathlib; f = pathlib.Path(sys.argv[1], 'answer').read_bytes()\n"
        script += "for _ in sys.stdin: sys.stdout.buffer.write(f); sys.stdout.flush()"
        monkeypatch.setattr("gmfbo.sources.worker.worker_process._START", script)
        super().__init__(folder)


@pytest.fixture
def private() -> Iterator[Path]:
    folder = PrivateFolder()
    yield folder.path
    folder.remove()


@pytest.mark.parametrize(
    "answer",
    [
        b"{}\n",
        b"null\n",
        b"[1]\n",
        b"junk\n",
        b'junk{"number": 1}\n',
        b'{"number": 2}\n',
        b"\xff\xfe\n",
        b"[" * 100_000 + b"\n",
        b"x" * (2**24 + 100_000) + b"\n",
    ],
    ids=["empty", "null", "list", "junk", "junk before", "stale", "bytes", "deep", "long"],
)
def test_a_line_that_is_no_answer_is_garbled(
    answer: bytes, private: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    worker = Answering(private, answer, monkeypatch)
    try:
        with pytest.raises(WorkerGarbled, match=r"^$"):
            worker.ask({}, 30.0)
    finally:
        worker.kill()


def test_the_answer_to_the_question_is_taken(
    private: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    worker = Answering(private, json.dumps({"number": 1, "x": 2}).encode() + b"\n", monkeypatch)
    assert worker.ask({}, 30.0) == {"number": 1, "x": 2}
    worker.kill()


@pytest.mark.usefixtures("own_temporary_folder")
def test_a_stage_that_foreign_code_wrote_is_no_traceback(axis: Path) -> None:
    reference = step_reference(0.01, at=0.05, horizon=0.1, unit="m")
    with FmuTwin(axis) as twin:
        twin.run({}, reference)
        runner: Any = twin._runner
        runner._arrays.progress[:] = (2**40, -(2**40))
        assert runner._stage().words == "stepping"
        assert runner._fmu() == 0


def test_folders_deeper_than_python_can_recurse_are_removed() -> None:
    folder = PrivateFolder()
    here = Path.cwd()
    try:
        os.chdir(folder.path)
        for _ in range(3000):
            os.mkdir("d")  # noqa: PTH102 - a path of that length is none
            os.chdir("d")
    finally:
        os.chdir(here)
    folder.remove()
    assert not folder.path.exists()
