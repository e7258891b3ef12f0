"""Lines of less than one and a half cycles over the stroke are curves, and no cogging."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from gmfbo.physics import CATALOGUE, Effect
from tests.physics.excitations import TYPICAL

LINES = [CATALOGUE[name] for name in ("cogging_torque", "torque_ripple")]


def cycles(number: float) -> float:
    """[rad per position unit] Wavenumber of so many cycles over the stroke."""
    return 2.0 * math.pi * number / TYPICAL.stroke


@pytest.mark.parametrize("effect", LINES, ids=lambda effect: effect.name)
def test_fits_start_at_lines_that_repeat(effect: Effect) -> None:
    lines = (cycles(0.8), cycles(7.0))
    excitation = replace(TYPICAL, wavenumbers=lines, ripple_wavenumbers=lines)
    starts = {start["wavenumber_1"] for start in effect.starts(excitation)}
    assert starts == {cycles(7.0)}


def test_where_no_line_repeats_a_typical_one_tells_what_would_be_seen() -> None:
    excitation = replace(TYPICAL, wavenumbers=(cycles(0.8),))
    (start,) = CATALOGUE["cogging_torque"].starts(excitation)
    assert start["wavenumber_1"] > cycles(2.0)
