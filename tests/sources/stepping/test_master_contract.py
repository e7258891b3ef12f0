"""The C master and stepping in Python are two ways to the same bits."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.recordings import Recording
from gmfbo.sources.binding.bind import bind
from gmfbo.sources.fmu_file.platforms import master_path
from gmfbo.sources.twin.parameter_values import run_parameters
from gmfbo.sources.twin.run_plan import Experiment
from gmfbo.sources.twin_file.twin_file import TwinFile
from gmfbo.sources.worker.runner import InProcess, Result
from tests.sources.conftest import AXIS, FAULTY, LOOP, TEST_FMUS

if TYPE_CHECKING:
    from tests.sources.conftest import WriteTwin

Stepped = Callable[..., tuple[Result, Result]]


@pytest.fixture
def stepped() -> Iterator[Stepped]:
    """Runs a twin natively and in Python."""
    runners: list[InProcess] = []

    def run(path: Path, recording: Recording, **parameters: float) -> tuple[Result, Result]:
        binding = bind(TwinFile.read(path), path.parent, path.name)
        chosen = run_parameters(binding, recording, parameters, {})
        order = Experiment.prepare(binding, recording, chosen, binding.file.step).order(0)
        runners.extend(InProcess(binding, native=native) for native in (True, False))
        native, python = (runner.run(order)[0] for runner in runners[-2:])
        return native, python

    yield run
    for runner in runners:
        runner.close()


def chirp(rows: int = 400, schedules: Mapping[str, NDArray[np.float64]] | None = None) -> Recording:
    time = 0.3 + np.arange(rows, dtype=np.float64) * 1e-3
    return Recording(
        time=time,
        signals={"reference": 0.05 * np.sin(200.0 * time**2)},
        schedules=schedules or {},
    )


def assert_same(native: Result, python: Result) -> None:
    assert native.outcome == python.outcome
    assert native.y.tobytes() == python.y.tobytes()


def test_the_c_master_is_there_for_this_machine() -> None:
    assert master_path() is not None


def test_a_closed_loop_inside_one_fmu_gives_the_same_bits(
    stepped: Stepped, write_twin: WriteTwin
) -> None:
    native, python = stepped(write_twin(AXIS), chirp())
    assert native.outcome.status == "ok"
    assert np.ptp(native.y[:, 0]) > 1e-3
    assert_same(native, python)


def test_wired_fmus_give_the_same_bits(stepped: Stepped, write_twin: WriteTwin) -> None:
    native, python = stepped(write_twin(LOOP), chirp())
    assert np.ptp(native.y[:, 1]) > 1.0
    assert_same(native, python)


def test_a_schedule_of_a_real_and_of_a_boolean_gives_the_same_bits(
    stepped: Stepped, write_twin: WriteTwin
) -> None:
    rows = np.arange(400)
    schedules = {
        "plant.viscous_friction": np.where(rows < 150, 60.0, 500.0),
        "controller.feedback_from_load": (rows >= 200).astype(float),
    }
    native, python = stepped(write_twin(LOOP), chirp(schedules=schedules))
    still, _ = stepped(write_twin(LOOP), chirp())
    assert_same(native, python)
    assert native.y[:151].tobytes() == still.y[:151].tobytes()
    assert not np.array_equal(native.y[152:200], still.y[152:200])
    assert not np.array_equal(native.y[202:], still.y[202:])


@pytest.mark.parametrize(
    ("fault", "status", "words"),
    [
        (4, "diverged", "an output is not finite at t = 0.321 s"),
        (5, "failed", "refused fmi2DoStep with 'discard'"),
        (6, "failed", "refused fmi2DoStep with 'error': asked for by parameter 'fault'"),
    ],
)
def test_a_stop_is_the_same_with_its_rows_and_its_words(
    fault: int, status: str, words: str, stepped: Stepped, write_twin: WriteTwin
) -> None:
    path = write_twin(FAULTY, TEST_FMUS / "faulty.fmu")
    native, python = stepped(path, chirp(), fault=fault, at=0.0195)
    assert_same(native, python)
    assert native.outcome.status == status
    assert words in native.outcome.message
    assert native.outcome.rows == 21
    assert np.isfinite(native.y[:21]).all()


def test_warnings_are_counted_alike(stepped: Stepped, write_twin: WriteTwin) -> None:
    path = write_twin(FAULTY, TEST_FMUS / "faulty.fmu")
    native, python = stepped(path, chirp(), fault=9, at=0.0195)
    assert_same(native, python)
    assert native.outcome.warnings == 379


def test_a_recording_of_one_row_reads_row_zero(stepped: Stepped, write_twin: WriteTwin) -> None:
    native, python = stepped(write_twin(AXIS), chirp(1))
    assert native.y.shape == (1, 2)
    assert_same(native, python)
