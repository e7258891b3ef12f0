"""Settings that hold for the whole test run."""

from __future__ import annotations

import gc
import os
import signal
from pathlib import Path

# Before NumPy and torch load: see gmfbo/__init__.py.
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

# Millions of objects of torch, of other packages and of the tests themselves stay to the end.
gc.disable()

import pytest  # noqa: E402
from hypothesis import settings  # noqa: E402

import gmfbo.retuning  # noqa: E402, F401 - all methods are listed before tests are collected

settings.register_profile("gmfbo", deadline=None, derandomize=True, print_blob=True)
settings.load_profile("gmfbo")

# A shell that starts the tests in the background has them ignore Ctrl-C, and they hand that down.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

TESTS = Path(__file__).parent
LONGEST = [
    TESTS / "notebooks",
    TESTS / "test_readme.py",
    TESTS / "cli" / "test_demo_command.py",
    TESTS / "diagnosis" / "test_honest_degradation.py",
    TESTS / "diagnosis" / "test_kinds_of_twins.py",
    TESTS / "test_reference.py",
    TESTS / "fmu_build" / "test_build.py",
    TESTS / "diagnosis",
    TESTS / "tuning",
]
"""A file is one process' work: one that takes a minute must not be the last to begin."""


def pytest_collection_finish() -> None:
    """Collect garbage from now on, but look at nothing that was there before the first test."""
    gc.freeze()
    gc.enable()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Order the tests, and skip the slow ones unless they are asked for."""
    _begin_with_the_longest(items)
    if os.environ.get("GMFBO_SLOW") != "1":
        _skip_slow(items)


def _begin_with_the_longest(items: list[pytest.Item]) -> None:
    """Begin with what takes longest, so that no process waits for another's last file."""

    def place(item: pytest.Item) -> int:
        among = [item.path.is_relative_to(path) for path in LONGEST]
        return among.index(True) if any(among) else len(among)

    items.sort(key=place)


def _skip_slow(items: list[pytest.Item]) -> None:
    for item in items:
        if item.get_closest_marker("slow"):
            item.add_marker(pytest.mark.skip(reason="slow: set GMFBO_SLOW=1 to run it"))
