"""When recordings that no fit has seen contradict the names."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.diagnosis.result.held_out_errors import Fit, SignalFit, contradicts_names

FLOOR = 1e-4
TIMES = st.floats(0.1, 100.0)


def fit_of(
    before: float, after: float, *, removed: float | None = None, held_out: bool = True
) -> Fit:
    """One signal's errors without and with the physics, times the noise floor."""
    signal = SignalFit(50.0 * FLOOR, before * FLOOR, after * FLOOR, math.nan, FLOOR)
    return Fit(("a.csv",), ("b.csv",) if held_out else (), {"position": signal}, removed)


@pytest.mark.parametrize(
    ("before", "after", "removed", "contradicts"),
    [
        (3.0, 5.0, 0.3, True),
        (3.0, 5.0, None, True),
        (3.0, 5.0, 0.9, False),  # it came to rest elsewhere within its gap
        (3.0, 3.2, 0.3, False),  # no clearer than chance
        (1.0, 1.4, 0.9, False),  # little more than noise either way
        (25.0, 11.0, 0.005, True),  # nothing of what physics could explain
        (25.0, 11.0, 0.3, False),
        (25.0, 11.0, None, False),
        (8.0, 1.0, 0.99, False),
    ],
)
def test_names_fall_where_unseen_recordings_are_clearly_worse_with_them(
    before: float, after: float, removed: float | None, contradicts: bool
) -> None:
    assert (
        contradicts_names(fit_of(before, after, removed=removed), falls=False, differs=True)
        is contradicts
    )


def test_where_next_to_nothing_is_to_be_explained_the_weighted_error_decides() -> None:
    """Where an axis happens to stop within its friction counts in an RMS error alone."""
    errors = fit_of(1.4, 2.4, removed=None)
    assert contradicts_names(errors, falls=False, differs=True)
    assert not contradicts_names(errors, falls=True, differs=True)
    assert contradicts_names(fit_of(1.4, 2.4, removed=0.3), falls=True, differs=True)


def test_errors_that_grow_are_told_even_where_most_is_removed() -> None:
    rested_elsewhere = fit_of(3.0, 5.0, removed=0.9)
    assert rested_elsewhere.is_worse
    assert not contradicts_names(rested_elsewhere, falls=False, differs=True)
    assert not fit_of(8.0, 1.0, removed=0.99).is_worse


@given(TIMES, TIMES)
def test_what_comes_near_to_noise_or_improves_is_never_contradicted(a: float, b: float) -> None:
    before, after = max(a, b), min(a, b)
    assert not contradicts_names(fit_of(before, after), falls=False, differs=True)
    assert not contradicts_names(fit_of(a, min(b, 1.5)), falls=False, differs=True)


def test_physics_that_never_acts_there_is_not_contradicted() -> None:
    """A limit that these recordings do not reach: what differs is how far the axis drifts."""
    assert contradicts_names(fit_of(3.7, 4.8), falls=False, differs=True)
    assert not contradicts_names(fit_of(3.7, 4.8), falls=False, differs=False)


def test_without_a_held_out_recording_nothing_contradicts() -> None:
    assert not contradicts_names(fit_of(3.0, 50.0, held_out=False), falls=False, differs=True)


def test_where_nothing_was_named_nothing_is_contradicted() -> None:
    assert not contradicts_names(fit_of(3.0, math.nan), falls=False, differs=True)
