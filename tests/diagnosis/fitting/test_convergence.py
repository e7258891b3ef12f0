"""A fit says whether it converged, and the fit of the twin's values goes on until it has."""

from __future__ import annotations

from contextlib import closing

import pytest

from gmfbo.diagnosis.fitting.fit import fit, fit_to_the_end
from tests.diagnosis.short_recordings import SERVO, SERVO_TRUTH, open_small

FAR = {"inertia": 0.018, "viscous": 0.18}


def test_a_fit_that_is_stopped_says_so_and_one_that_ends_by_itself_does_not() -> None:
    with closing((case := open_small(SERVO.twin(), SERVO.recordings({}))).simulations):
        stopped = fit(case.misfit, case.base.hypothesis, FAR, iterations=2)
        ended = fit_to_the_end(case.misfit, case.base.hypothesis, FAR)
        assert stopped is not None
        assert ended is not None
        assert not stopped.converged
        assert not stopped.measured_by(case.plain).converged
        assert ended.converged
        assert ended.parameters["inertia"] == pytest.approx(SERVO_TRUTH["inertia"], rel=0.01)
        assert case.base.converged
