"""Ctrl-C where a compiled library that calls Python back makes another error of it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from gmfbo.interrupt import unwrapped_interrupt
from gmfbo.recordings.store.study_folder import StudyStore
from gmfbo.tuning.query.progress import Progress
from gmfbo.tuning.tuner import Tuner
from tests.tuning.analytic_axis import AnalyticAxis, write_study


def called_back() -> None:
    """Raise what CPython raises when a compiled function ignored an exception of its callback."""
    try:
        raise KeyboardInterrupt
    except KeyboardInterrupt as pressed:
        raise SystemError("a built-in returned a result with an exception set") from pressed


def called_back_twice() -> None:
    """Raise it again as the callback of another compiled function does."""
    try:
        called_back()
    except SystemError as error:
        raise SystemError("another returned a result with an exception set") from error


@pytest.mark.parametrize("wrapped", [called_back, called_back_twice])
def test_a_wrapped_interrupt_is_an_interrupt(wrapped: Callable[[], None]) -> None:
    with pytest.raises(KeyboardInterrupt), unwrapped_interrupt():
        wrapped()


@pytest.mark.parametrize("cause", [None, ValueError("a fault")])
def test_another_error_stays_what_it_is(cause: Exception | None) -> None:
    with pytest.raises(SystemError, match="a fault of its own"), unwrapped_interrupt():
        raise SystemError("a fault of its own") from cause


def test_a_study_stopped_so_says_that_it_was_interrupted(tmp_path: Path) -> None:
    def stop(step: Progress) -> None:
        called_back()

    study = write_study(tmp_path)
    with (
        Tuner(study, is1=AnalyticAxis(), is2=AnalyticAxis(inertia=0.2)) as tuner,
        pytest.raises(KeyboardInterrupt),
    ):
        tuner.run(stop)
    with StudyStore.open(study.location) as store:
        assert store.events()[-1]["event"] == "interrupt"
