"""Sensitivities by central differences, against much finer ones."""

from __future__ import annotations

from contextlib import closing

import numpy as np

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.central_slopes import with_central_slopes
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.misfit import chi2
from tests.diagnosis.short_recordings import QUIET_SERVO, open_small


def error(case: Case, fitted: Fitted, place: int) -> float:
    """Distance of one whitened sensitivity from a central difference of a tenth of the step."""
    step = 0.1 * fitted.hypothesis.difference_sizes(fitted.x)[place]
    moves = np.zeros((2, fitted.x.size))
    moves[:, place] = step, -step
    ahead, back = case.misfit.run_moved(fitted.hypothesis, fitted.x, moves, parallel=False)
    fine = case.misfit.change(ahead, back)
    pairs = zip(fine, fitted.sensitivity, strict=True)
    return float(np.sqrt(chi2(tuple(f / (2.0 * step) - own[place] for f, own in pairs))))


def test_central_differences_are_ten_times_as_exact_as_those_of_the_fit() -> None:
    with closing((case := open_small(QUIET_SERVO.twin(), QUIET_SERVO.recordings({}))).simulations):
        central = with_central_slopes(case.misfit, case.base)
        for place in range(central.x.size):
            assert error(case, central, place) < 0.1 * error(case, case.base, place)
    np.testing.assert_array_equal(central.x, case.base.x)
