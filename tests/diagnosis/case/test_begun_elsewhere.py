"""Parameters of an axis that lives at its limit, which slopes alone do not find."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.case import open_case
from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.misfit import Misfit
from tests.diagnosis.short_recordings import Axis, moves, multisine, open_small, triangle

TRUTH = {"mass": 112.8, "viscous_friction": 282.0}  # 19 and 39 % more than the twin's
LIMIT = 2.5  # [V] of twin and axis, which are at it half of the time
LIMITED_AXIS = Axis(
    model="linear_axis",
    truth={**TRUTH, "voltage_limit": LIMIT},
    gains={"kp": 155.9, "kv": 303.3, "voltage_limit": LIMIT},
    noise={"position": 1e-6, "drive_voltage": 0.01},
)


def small(reference: NDArray[np.float64]) -> NDArray[np.float64]:
    return 0.03 * reference


def opened(axis: Axis = LIMITED_AXIS) -> Case:
    references = [lambda t, shape=shape: small(shape(t)) for shape in (multisine, moves, triangle)]
    return open_small(axis.twin(), axis.recordings({}, references, seconds=2.0))


def as_it_was(misfit: Misfit, base: Fitted) -> Fitted:
    return base


def test_parameters_behind_a_limit_are_found() -> None:
    with closing((case := opened()).simulations):
        assert case.base.parameters == pytest.approx(TRUTH, rel=5e-3)


def test_by_slopes_alone_they_are_not(monkeypatch: pytest.MonkeyPatch) -> None:
    """Negative control: the fit ends by itself, ten times the allowed error from the truth."""
    monkeypatch.setattr(open_case, "fitted_from_elsewhere", as_it_was)
    with closing((case := opened()).simulations):
        assert case.base.converged
        assert case.base.parameters["mass"] < 0.95 * TRUTH["mass"]


@pytest.mark.slow
def test_where_the_first_fit_is_right_nothing_is_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    free = replace(LIMITED_AXIS, truth=TRUTH, gains={"kp": 155.9, "kv": 303.3})
    with closing((case := opened(free)).simulations):
        runs = case.simulations.runs
    monkeypatch.setattr(open_case, "fitted_from_elsewhere", as_it_was)
    with closing((case := opened(free)).simulations):
        assert case.simulations.runs == runs
