"""A pulse of one recording beside a law that is not right is where that law leaves most."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from gmfbo.diagnosis.naming.conditions import _passes_amid_misfit
from gmfbo.diagnosis.naming.decision import Decision, Evidence

LEFT = 9000.0  # chi2, of which a tenth is beyond noise
SIZE, DISPERSION = 9000, 1.0 / 0.9  # of a library of which the best leaves as much


def decision(*, named: bool = True, dispersion: float = DISPERSION) -> Decision:
    return cast(
        Decision,
        SimpleNamespace(
            rounds=[object()] if named else [],
            model=SimpleNamespace(chi2=LEFT, residual=[np.zeros(SIZE)]),
            dispersion=dispersion,
        ),
    )


def pulse(gain: float, only: int | None = 0) -> Evidence:
    return cast(Evidence, SimpleNamespace(gain=gain, effect=SimpleNamespace(only=only)))


@pytest.mark.parametrize(("gain", "refused"), [(440.0, True), (460.0, False)])
def test_it_has_to_be_half_of_what_is_beyond_noise(gain: float, refused: bool) -> None:
    assert _passes_amid_misfit(pulse(gain), decision()) is refused


def test_what_all_recordings_show_and_what_comes_first_need_not() -> None:
    assert not _passes_amid_misfit(pulse(100.0, only=None), decision())
    assert not _passes_amid_misfit(pulse(100.0), decision(named=False))


def test_where_only_noise_is_left_any_gain_is_enough() -> None:
    assert not _passes_amid_misfit(pulse(100.0), decision(dispersion=1.0))
