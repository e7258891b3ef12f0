"""A misaligned column and a law that looks like it: told together only where both explain."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from contextlib import closing

import numpy as np
import pytest

from gmfbo.diagnosis.naming.alignment_told import FAR, LAWS, _Seen, alignments
from gmfbo.diagnosis.result.estimated import Alignment
from gmfbo.physics import CATALOGUE
from gmfbo.recordings.recording import Recording
from tests.diagnosis.short_recordings import SERVO, open_small

CONSTANT = {"constant_torque_offset.level": 0.3}
OTHERS = {law for laws in LAWS.values() for law in laws} - {"constant_torque_offset"}


def moved(
    name: str, *, scale: float = 1.0, offset: float = 0.0, late: float = 0.0
) -> list[Recording]:
    """Recordings of an axis that lacks nothing, one column of which is logged wrongly."""
    found = []
    for recording in SERVO.recordings({}):
        columns = {n: recording.signal(n) for n in ("position", "torque_command")}
        shifted = np.interp(recording.time - late, recording.time, columns[name])
        found.append(recording.with_signals({**columns, name: scale * shifted + offset}))
    return found


def aligned(
    recordings: Sequence[Recording], untested: Collection[str] = ()
) -> dict[str, Alignment]:
    """Alignment against the twin with its parameters refitted."""
    with SERVO.twin() as twin, closing((case := open_small(twin, recordings)).simulations):
        return alignments(case, case.base, untested)


def test_what_the_recordings_hardly_tell_of_a_column_is_told_as_its_prior_has_it() -> None:
    """By one size at a time: the mean of two normal estimates, each by its variance."""
    seen = _Seen(np.array([-0.06, 2.5, 1e-3]), np.diag([0.03**2, 1e-12, 1e-8]))
    scale, offset, shift = seen.believed(np.array([3e-4, 0.1, 1e-4]))
    assert scale == pytest.approx(-0.06 * 3e-4**2 / (3e-4**2 + 0.03**2), rel=1e-9)
    assert offset == pytest.approx(2.5, rel=1e-9)  # certain, whatever is usual
    assert shift == pytest.approx(0.5e-3, rel=1e-9)
    assert seen.believed(np.zeros(3)) == pytest.approx(np.zeros(3))


def test_columns_of_a_right_twin_are_within_their_priors() -> None:
    for column in aligned(SERVO.recordings({})).values():
        assert column.beyond_prior == {}
        assert column.rival is None


@pytest.mark.parametrize(
    ("name", "kind", "wrong"),
    [
        ("torque_command", "offset", {"offset": 0.3}),
        pytest.param("torque_command", "scale", {"scale": 1.15}, marks=pytest.mark.slow),
        pytest.param("torque_command", "shift", {"late": 3e-3}, marks=pytest.mark.slow),
        pytest.param("position", "scale", {"scale": 1.01}, marks=pytest.mark.slow),
    ],
)
def test_a_column_that_no_law_explains_is_off_and_has_no_rival(
    name: str, kind: str, wrong: dict[str, float]
) -> None:
    """In the loop each of these laws moves the other column too, which was not moved."""
    column = aligned(moved(name, **wrong))[name]
    assert column.beyond_prior[kind] > FAR
    assert column.rival is None


@pytest.mark.slow
def test_a_delay_that_was_swallowed_by_an_early_column_is_its_rival() -> None:
    recordings = SERVO.recordings({"transport_delay.delay": 3e-3})
    column = aligned(recordings)["torque_command"]
    assert column.shift < 0.0
    assert column.beyond_prior["shift"] > FAR
    assert column.rival == "transport_delay"


def test_a_constant_torque_that_offsets_columns_is_their_rival() -> None:
    found = aligned(SERVO.recordings(CONSTANT, held=1.0), OTHERS)
    assert {column.rival for column in found.values()} == {"constant_torque_offset"}
    assert found["torque_command"].offset == pytest.approx(-0.3, abs=0.01)


def test_a_law_that_was_excluded_is_no_rival() -> None:
    """Negative control of the test above."""
    found = aligned(SERVO.recordings(CONSTANT, held=1.0), {*OTHERS, "constant_torque_offset"})
    assert all(column.rival is None for column in found.values())
    assert found["torque_command"].beyond_prior["offset"] > FAR


def test_the_laws_that_look_alike_are_in_the_catalogue() -> None:
    assert {law for laws in LAWS.values() for law in laws} <= set(CATALOGUE)
