"""Every unit is done once, whatever its workers do."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Callable, Mapping
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import pytest

from gmfbo import Study
from gmfbo.errors import InputError, SimulationError
from gmfbo.studies import dispatch
from gmfbo.studies.comparison_folder import ComparisonFolder
from gmfbo.studies.dispatch import ATTEMPTS, Dispatch
from gmfbo.studies.engine import InProcess, OnExecutor, Processes
from gmfbo.studies.planned_comparison import PlannedComparison, Wanted
from gmfbo.studies.unit import Failed, Made, Missing, Result, Unit
from gmfbo.tuning.methods import find_method
from tests.studies.small_study import write_small_study

MADE = Made(None, {})


class Threads:
    """An engine of two threads that does with a unit what a test says."""

    dies_whole = False
    workers = 2

    def __init__(self, do: Callable[[Unit, int, Mapping[str, bytes]], Result]) -> None:
        self.do, self.times = do, Counter[str]()
        self._pool = ThreadPoolExecutor(8)

    def submit(self, unit: Unit, contents: Mapping[str, bytes]) -> Future[Result]:
        self.times[unit.label] += 1
        return self._pool.submit(self.do, unit, self.times[unit.label], contents)

    def renew(self) -> None: ...

    def stop(self) -> None: ...

    def close(self) -> None: ...


@pytest.fixture
def planned(tmp_path: Path) -> PlannedComparison:
    """Four runs of the small study."""
    methods = tuple((find_method(name), 2) for name in ("random", "bo_ei"))
    folder = ComparisonFolder(tmp_path / "out")
    study = Study.read(write_small_study(tmp_path))
    return PlannedComparison.begin(study, folder, Wanted(methods, 0, 5, keep_trials=False))


def outcome_of(engine: Threads | Processes, planned: PlannedComparison) -> dict[str, Result]:
    """Run all units; each is told of once."""
    came: dict[str, Result] = {}

    def finished(unit: Unit, result: Made | Failed) -> None:
        assert unit.label not in came
        came[unit.label] = result

    Dispatch(engine, planned.gathered.contents, finished).run(planned.runs())
    assert len(came) == 4
    return came


def test_lost_unit_is_done_again(planned: PlannedComparison) -> None:
    def do(unit: Unit, time: int, contents: Mapping[str, bytes]) -> Result:
        if time == 1:
            raise CancelledError
        return MADE

    engine = Threads(do)
    assert set(outcome_of(engine, planned).values()) == {MADE}
    assert set(engine.times.values()) == {2}


def test_unit_that_is_lost_again_and_again_is_given_up_and_the_others_are_done(
    planned: PlannedComparison,
) -> None:
    def do(unit: Unit, time: int, contents: Mapping[str, bytes]) -> Result:
        if unit.label.endswith("bo_ei-1"):
            raise ConnectionError("the worker went away")
        return MADE

    engine = Threads(do)
    came = outcome_of(engine, planned)
    (failed,) = [one for one in came.values() if isinstance(one, Failed)]
    assert "the worker went away" in failed.reason
    assert max(engine.times.values()) == ATTEMPTS


def test_unit_of_which_nothing_is_heard_is_done_by_another(
    planned: PlannedComparison, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dispatch, "PATIENCE_S", 0.2)
    monkeypatch.setattr(dispatch, "_LOOK_EVERY_S", 0.05)
    never = threading.Event()

    def do(unit: Unit, time: int, contents: Mapping[str, bytes]) -> Result:
        if time == 1 and unit.label.endswith("random-0"):
            never.wait(30.0)
        return MADE

    engine = Threads(do)
    assert set(outcome_of(engine, planned).values()) == {MADE}
    never.set()
    assert engine.times.total() == 5


def test_contents_go_to_who_lacks_them_and_to_nobody_else(planned: PlannedComparison) -> None:
    def do(unit: Unit, time: int, contents: Mapping[str, bytes]) -> Result:
        if unit.label.endswith("random-0") and time == 1:
            return Missing(frozenset(unit.files.hashes.values()))
        expected = planned.gathered.contents if unit.label.endswith("random-0") else {}
        assert dict(contents) == expected
        return MADE

    assert set(outcome_of(Threads(do), planned).values()) == {MADE}


@pytest.mark.slow
def test_files_travel_once_to_each_process(planned: PlannedComparison) -> None:
    whole = sum(map(len, planned.gathered.contents.values()))
    engine, came = Processes(2), []
    handed_out = Dispatch(engine, planned.gathered.contents, lambda unit, one: came.append(one))
    try:
        handed_out.run(planned.runs())
    finally:
        engine.close()
    assert all(isinstance(one, Made) for one in came)
    assert whole <= handed_out.contents_sent <= 2 * whole


def test_worker_of_another_version_is_named(planned: PlannedComparison) -> None:
    units = [replace(unit, version="0.0.1") for unit in planned.runs()]
    came: list[Made | Failed] = []
    Dispatch(InProcess(), {}, lambda unit, one: came.append(one)).run(units[:1])
    (failed,) = came
    assert isinstance(failed, Failed)
    assert "the campaign 0.0.1; install the same on all workers" in failed.reason


def test_broken_executor_of_the_user_is_named_and_what_is_done_is_kept(
    planned: PlannedComparison,
) -> None:
    def fail() -> None:
        raise OSError("no memory")

    pool = ThreadPoolExecutor(1, initializer=fail)
    with pytest.raises(SimulationError, match="the executor ThreadPoolExecutor broke"):
        Dispatch(OnExecutor(pool), {}, lambda unit, one: None).run(planned.runs())


def test_executor_that_does_not_say_its_workers_is_asked_for_them() -> None:
    class Quiet(ThreadPoolExecutor):
        def __init__(self) -> None:
            super().__init__(3)
            del self._max_workers

    with pytest.raises(InputError, match="Quiet does not say how many workers"):
        OnExecutor(Quiet())
    assert OnExecutor(Quiet(), 5).workers == 5
    assert OnExecutor(ThreadPoolExecutor(3)).workers == 3
